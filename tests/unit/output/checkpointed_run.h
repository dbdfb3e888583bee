#pragma once
// States of runs that the tests of checkpoints write and read.

#include "../particles/soil_block.h"
#include "read_back.h"

#include <gtest/gtest.h>
#include <kedge/output/checkpoint.h>

namespace kedge::test
{
inline const std::string checkpointed_input =
    R"({"domain": {"size": 2.0}, "analysis": [{"load steps": 10}], "output": {"vtk": "on"}})";

inline RigidSystems two_points()
{
  RigidSystems bodies;
  bodies.points.resize(2);
  return bodies;
}

/// Everything that a run keeps between two steps, empty at first.
template <int dim> struct Fresh
{
  explicit Fresh(const MPI_Comm communicator)
      : soil(SoilBlock<dim>::layout(), SoilBlock<dim>::two_layers(), {}, communicator),
        mesh(soil.mesh()),
        particles(soil.particles()),
        contact(soil.contact())
  {
  }

  void read(const std::string& file, const std::string& other_input)
  {
    progress = read_checkpoint(soil, bodies, other_input, file);
  }

  Soil<dim> soil;
  const BackgroundMesh<dim>& mesh;
  const ParticleSet<dim>& particles;
  const Contact<dim>& contact;
  RigidSystems bodies = two_points();
  RunProgress progress;
};

/// A run in the middle of a stage: refined cells, disturbed particles, some of them waiting outside the window.
template <int dim> struct Interrupted : SoilBlock<dim>
{
  explicit Interrupted(const MPI_Comm communicator) : SoilBlock<dim>(communicator)
  {
    this->refine(false);
    this->disturb();
    Window<dim> window = this->mesh.leaves().window;
    window.upper[0] -= 1;
    this->mesh.set_window(window);

    std::vector<ContactRecord> records;
    for (const long long id : this->particles.ids())
      for (std::uint32_t corner = 0; corner < 2 && noise(id, 1) < 0.4; ++corner)
        records.push_back({id,
                           corner,
                           1,
                           {noise(id, 2), -noise(id, 3), noise(id, corner)},
                           -noise(id, 4),
                           noise(id, 5),
                           noise(id, 6) < 0.5,
                           noise(id, 7),
                           {noise(id, 8),
                            noise(id, 9),
                            noise(id, 10),
                            {noise(id, 11), noise(id, 12), noise(id, 13), noise(id, 14)}}});
    this->contact.import_history(records, this->particles.ids());

    for (unsigned int i = 0; i < 2; ++i)
    {
      RigidPoint& point = bodies.points[i];
      for (unsigned int d = 0; d < 3; ++d)
        point.pose.position[d] = noise(d, i);
      point.pose.rotation = rotation_from_vector({noise(3, i), noise(4, i), noise(5, i)});
      for (unsigned int d = 0; d < 6; ++d)
      {
        point.velocity[d] = noise(d, 10 + i);
        point.acceleration[d] = noise(d, 20 + i);
        point.last_increment[d] = noise(d, 30 + i);
      }
    }
    std::vector<double>& prediction = this->soil.parts().prediction.emplace();
    for (const auto& x : this->mesh.leaves().node_position)
      for (unsigned int d = 0; d < dim; ++d)
        prediction.push_back(noise_at(x, dim, d));
    this->soil.parts().n_deleted = 4;
    progress = {2, {4096, 12345, 64, 3, 2, 4, true}, 77, 15, 0.625, 72.5, true, "a {\"summary\"} with umlauts: ä"};
  }

  void write(const std::string& file, const std::string& of_input = checkpointed_input) const
  {
    write_checkpoint(this->soil, bodies, progress, of_input, file);
  }

  RigidSystems bodies = two_points();
  RunProgress progress;
};

template <typename Dimension> class CheckpointTest : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

protected:
  /// Writes the state of an interrupted run on all ranks and reads it again, with another input if one is given.
  void write() { Interrupted<dim>(MPI_COMM_WORLD).write(file); }
  void read(const std::string& other_input = checkpointed_input)
  {
    Fresh<dim> run(MPI_COMM_WORLD);
    run.read(file, other_input);
  }

  const TemporaryFolder folder;
  const std::string file = folder / "run.restart";
};

using CheckpointDimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
} // namespace kedge::test
