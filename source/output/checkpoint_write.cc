#include "checkpoint_layout.h"

#include <kedge/base/communication.h>
#include <kedge/mesh/octree.h>
#include <kedge/output/hdf5_file.h>
#include <nlohmann/json.hpp>
#include <zlib.h>

namespace kedge
{
using namespace checkpoint;

std::vector<std::int64_t> checkpoint::describe_surfaces(const RigidSystems& bodies)
{
  std::vector<std::int64_t> rows;
  for (const WeldedSurface& welded : bodies.surfaces)
  {
    const TriangleMesh& mesh = welded.surface.mesh();
    unsigned long crc = ::crc32(0, nullptr, 0);
    const auto add = [&crc](const auto& entry)
    { crc = ::crc32(crc, reinterpret_cast<const unsigned char*>(entry.data()), sizeof(entry)); };
    for (const Eigen::Vector3d& vertex : mesh.vertices)
      add(vertex);
    for (const std::array<unsigned int, 3>& triangle : mesh.triangles)
      add(triangle);
    rows.insert(rows.end(), {static_cast<std::int64_t>(mesh.vertices.size()),
                             static_cast<std::int64_t>(mesh.triangles.size()), static_cast<std::int64_t>(crc)});
  }
  return rows;
}

namespace
{
nlohmann::json to_json(const RunProgress& progress, const long long deleted)
{
  const ClockState& clock = progress.clock;
  return {{"stage", progress.stage},
          {"clock",
           {clock.ticks_per_step, clock.position, clock.limit, clock.cuts, clock.made, clock.patience, clock.on_trial}},
          {"step", progress.step},
          {"steps in stage", progress.steps_in_stage},
          {"deleted", deleted},
          {"overshoots", progress.newton.overshoots},
          {"at rest", progress.newton.at_rest},
          {"has warned of window", progress.has_warned_of_window},
          {"summary", progress.summary}};
}

template <int dim> void write_cells_and_particles(const Soil<dim>& soil, Hdf5Writer& file)
{
  std::vector<std::int64_t> leaves, ids;
  std::vector<double> particles;
  const auto cells = cells_in_forest_order(soil.mesh());
  for (const auto& cell : cells)
  {
    const LeafPlace<dim> place = place_of(cell, soil.mesh());
    leaves.push_back(place.level);
    leaves.insert(leaves.end(), place.index.begin(), place.index.end());
    leaves.push_back(soil.particles().handler().n_particles_in_cell(cell));
    for (const auto& particle : soil.particles().handler().particles_in_cell(cell))
    {
      ids.push_back(particle.get_id());
      for (unsigned int d = 0; d < dim; ++d)
        particles.push_back(particle.get_location()[d]);
      const auto data = particle.get_properties();
      particles.insert(particles.end(), data.begin(), data.end());
    }
  }
  file.write_rows("leaves", leaves, leaf_width<dim>);
  file.write_rows("leaves of ranks", std::vector<std::int64_t>{static_cast<std::int64_t>(cells.size())}, 1);
  file.write_rows("particle numbers", ids, 1);
  file.write_rows("particles", particles, particle_width<dim>);
}

template <int dim> void write_prediction(const Soil<dim>& soil, Hdf5Writer& file)
{
  const LeafTable<dim>& table = soil.mesh().leaves();
  const Prediction& prediction = soil.prediction();
  std::vector<double> nodes;
  if (prediction)
    for (std::size_t node = 0; node < table.node_position.size(); ++node)
      if (table.node_owner_is_me[node])
      {
        nodes.insert(nodes.end(), table.node_position[node].begin(), table.node_position[node].end());
        nodes.insert(nodes.end(), prediction->begin() + dim * node, prediction->begin() + dim * (node + 1));
      }
  file.write_rows("prediction", nodes, node_width<dim>);
}

template <int dim> void write_contact(const Contact<dim>& contact, Hdf5Writer& file)
{
  std::vector<std::int64_t> keys;
  std::vector<double> values;
  for (const ContactRecord& record : contact.export_history())
  {
    keys.insert(keys.end(), {record.particle, record.corner, record.surface});
    values.insert(values.end(), record.tangential, record.tangential + 3);
    values.push_back(record.reference_gap);
    values.push_back(record.multiplier);
    values.push_back(record.bonded);
    values.push_back(record.pressure);
    const auto& [farthest_off, farthest_in, opening, approach] = record.memory;
    values.insert(values.end(), {farthest_off, farthest_in, opening, approach.now, approach.most, approach.least,
                                 approach.beside_edges});
  }
  file.write_rows("contact keys", keys, contact_key_width);
  file.write_rows("contact", values, contact_width);
}

/// All ranks know the bodies; rank 0 writes them.
void write_bodies(const RigidSystems& bodies, const bool root, Hdf5Writer& file)
{
  std::vector<double> rows;
  if (root)
    for (const RigidPoint& point : bodies.points)
    {
      const auto append = [&rows](const auto& x) { rows.insert(rows.end(), x.data(), x.data() + x.size()); };
      append(point.pose.position);
      append(point.pose.rotation.coeffs());
      append(point.last_increment);
      append(point.velocity);
      append(point.acceleration);
    }
  file.write_rows("rigid points", rows, body_width);
}
} // namespace

template <int dim>
void write_checkpoint(const Soil<dim>& soil, const RigidSystems& bodies, const RunProgress& progress,
                      const std::string& input, const std::string& path, const std::string& kept)
{
  const MPI_Comm communicator = soil.communicator();
  Hdf5Writer file(path, communicator);
  file.write_text("version", version_text(dim));
  file.write_text("particle fields", field_names());
  file.write_text("program", progress.program);
  file.write_text("input", input);
  file.write_text("progress", to_json(progress, soil.n_deleted()).dump());
  const Window<dim>& window = soil.mesh().leaves().window;
  std::vector<std::int64_t> planes(window.lower.begin(), window.lower.end());
  planes.insert(planes.end(), window.upper.begin(), window.upper.end());
  const bool root = rank_of(communicator) == 0;
  file.write_rows("window", root ? planes : std::vector<std::int64_t>(), 2 * dim);
  file.write_rows("surfaces", root ? describe_surfaces(bodies) : std::vector<std::int64_t>(), surface_width);
  write_cells_and_particles(soil, file);
  write_contact(soil.contact(), file);
  write_bodies(bodies, root, file);
  write_prediction(soil, file);
  file.finish(kept);
}

template void write_checkpoint<2>(const Soil<2>&, const RigidSystems&, const RunProgress&, const std::string&,
                                  const std::string&, const std::string&);
template void write_checkpoint<3>(const Soil<3>&, const RigidSystems&, const RunProgress&, const std::string&,
                                  const std::string&, const std::string&);
} // namespace kedge
