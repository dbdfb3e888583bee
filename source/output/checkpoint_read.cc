#include "checkpoint_layout.h"

#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/mesh/octree.h>
#include <kedge/output/hdf5_file.h>
#include <kedge/soil/node_questions.h>
#include <map>
#include <nlohmann/json.hpp>

namespace kedge
{
using namespace checkpoint;

namespace
{
using Json = nlohmann::json;

RunProgress progress_from(const Json& json)
{
  RunProgress progress;
  progress.stage = json.at("stage");
  const Json& clock = json.at("clock");
  progress.clock = {clock.at(0), clock.at(1), clock.at(2), clock.at(3), clock.at(4), clock.at(5), clock.at(6)};
  progress.step = json.at("step");
  progress.steps_in_stage = json.at("steps in stage");
  progress.newton.overshoots = json.at("overshoots");
  progress.newton.at_rest = json.value("at rest", 0.); // not in files of earlier programs
  progress.has_warned_of_window = json.at("has warned of window");
  progress.summary = json.at("summary");
  return progress;
}

Json parse(const std::string& text, const std::string& path)
{
  const Json json = Json::parse(text, nullptr, false);
  if (json.is_discarded())
    throw FileError(path, "is damaged: a text in it is not JSON; use an older restart file or start again");
  return json;
}

/// The key of a stage that may grow, since its steps stay the same: not where they are shares of the stage, as a
/// gravity ramp, a body force over the load fraction and the basis step "auto" are.
const char* key_of_end(const Json& stage, const Json& input)
{
  if (stage.value("type", "") == "static")
    return stage.value("load", "") == "full" && !input.at("domain").contains("body force") ? "load steps" : nullptr;
  if (stage.value("type", "") == "explicit" && !(stage.contains("basis step") && stage["basis step"].is_number()))
    return nullptr;
  return "final time";
}

void forget_comments(Json& value)
{
  if (value.is_object())
    value.erase("comment");
  for (Json& entry : value)
    if (entry.is_structured())
      forget_comments(entry);
}

void forget_names_of_surfaces(Json& input)
{
  for (Json& system : input["rigid bodies"])
    if (system.contains("stl files"))
      for (Json& surface : system["stl files"])
        surface.erase("stl");
}

/// Removes the end of the last stage from both inputs if it is later now: up to the restart file the run is the same.
void forget_later_end(Json& now, Json& then)
{
  if (now.at("analysis").size() != then.at("analysis").size())
    return;
  Json &stage = now["analysis"].back(), &stage_then = then["analysis"].back();
  const char* const key = key_of_end(stage, now);
  if (key && stage.contains(key) && stage_then.contains(key) && stage[key] > stage_then[key])
  {
    stage.erase(key);
    stage_then.erase(key);
  }
}

/// Throws InputError if two inputs differ in a value that affects the state.
void require_same_input(const std::string& now, const std::string& then, const std::string& path)
{
  Json a = parse(then, path), b = Json::parse(now);
  for (const char* free : {"output", "solver", "GPU", "$schema"})
  {
    a.erase(free);
    b.erase(free);
  }
  for (Json* input : {&a, &b})
  {
    forget_comments(*input);
    forget_names_of_surfaces(*input); // the surfaces themselves are compared
  }
  forget_later_end(b, a);
  const Json difference = Json::diff(a, b);
  if (!difference.empty())
    throw InputError("restart",
                     fmt::format("{} belongs to an input with another value of {}", path,
                                 difference[0].at("path").get<std::string>()),
                     "restart with the input of the first run; only \"output\", \"solver\", \"GPU\", \"comment\" "
                     "and \"$schema\" may differ, and the last stage may have a later \"final time\" (explicit: where "
                     "\"basis step\" "
                     "is a number) or "
                     "more \"load steps\" (with \"load\": \"full\" and no \"body force\")");
}

/// Throws InputError where a surface is not the one that the file was written with.
void require_same_surfaces(const RigidSystems& bodies, const std::vector<std::int64_t>& then, const std::string& path)
{
  const std::vector<std::int64_t> now = describe_surfaces(bodies);
  for (std::size_t i = 0; i < std::max(now.size(), then.size()); i += surface_width)
    if (now.size() != then.size() || !std::equal(&now[i], &now[i] + surface_width, &then[i]))
      throw InputError(
          "rigid bodies",
          fmt::format("surface {} of all bodies is not the one that {} was written with", i / surface_width + 1, path),
          "restart with the STL files of the first run, or start again without --restart");
}

/// A point of the grid as whole numbers, which do not depend on round-off.
template <int dim> using NodeKey = std::array<std::int64_t, dim>;
constexpr int key_depth = 30; // levels below the base cells; no tree is so deep

template <int dim> NodeKey<dim> node_key(const double* position, const double base_size)
{
  NodeKey<dim> key;
  for (unsigned int d = 0; d < dim; ++d)
    key[d] = std::llround(std::ldexp(position[d] / base_size, key_depth));
  return key;
}

/// m
template <int dim> std::array<double, dim> position_of(const NodeKey<dim>& key, const double base_size)
{
  std::array<double, dim> position;
  for (unsigned int d = 0; d < dim; ++d)
    position[d] = std::ldexp(static_cast<double>(key[d]), -key_depth) * base_size;
  return position;
}

/// This rank's part of a table of which every rank reads as much.
template <typename T>
std::vector<T> read_share(const Hdf5Reader& file, const char* const table, const unsigned int width,
                          const MPI_Comm communicator)
{
  const std::size_t n = file.n_rows(table, width), rank = rank_of(communicator), n_ranks = size_of(communicator),
                    first = n * rank / n_ranks;
  return file.read_rows<T>(table, width, first, n * (rank + 1) / n_ranks - first);
}

template <int dim> std::vector<LeafPlace<dim>> leaves_from(const std::vector<std::int64_t>& rows)
{
  constexpr unsigned int width = leaf_width<dim>;
  std::vector<LeafPlace<dim>> leaves(rows.size() / width);
  for (std::size_t i = 0; i < leaves.size(); ++i)
  {
    leaves[i].level = rows[width * i];
    std::copy_n(&rows[width * i + 1], dim, leaves[i].index.begin());
  }
  return leaves;
}

template <int dim> using Cells = std::vector<typename BackgroundMesh<dim>::Cell>;

/// The rows of this rank's cells, which lie next to each other in the file. The mesh must have the file's leaves.
template <int dim>
std::vector<std::int64_t> read_leaves(const Hdf5Reader& file, const Cells<dim>& cells, const MPI_Comm communicator)
{
  return file.read_rows<std::int64_t>("leaves", leaf_width<dim>, sum_over_lower_ranks(cells.size(), communicator),
                                      cells.size());
}

template <int dim> void read_mesh(const SoilParts<dim>& soil, const Hdf5Reader& file)
{
  constexpr unsigned int width = leaf_width<dim>;
  auto& forest = soil.mesh.triangulation();
  const MPI_Comm communicator = soil.mesh.communicator();
  refine_to(soil.mesh, leaves_from<dim>(read_share<std::int64_t>(file, "leaves", width, communicator)));
  const Cells<dim> cells = cells_in_forest_order(soil.mesh);
  bool fits = forest.n_global_active_cells() == file.n_rows("leaves", width);
  std::vector<std::int64_t> rows;
  if (fits) // on all ranks
    rows = read_leaves<dim>(file, cells, communicator);
  const std::vector<LeafPlace<dim>> leaves = leaves_from<dim>(rows);
  for (std::size_t i = 0; fits && i < cells.size(); ++i)
  {
    const LeafPlace<dim> place = place_of(cells[i], soil.mesh);
    fits = place.level == leaves[i].level && place.index == leaves[i].index;
  }
  if (min_over_ranks(fits, communicator) < 1.)
    throw InputError("restart", "the cells of the restart file do not fit the grid of this input",
                     "restart with the input of the first run");

  // As many ranks as wrote the file: each gets its own leaves. Otherwise distribute them by their work.
  const std::vector<std::int64_t> counts = file.read_all<std::int64_t>("leaves of ranks", 1);
  if (counts.size() == static_cast<std::size_t>(size_of(communicator)))
    repartition_to(soil.mesh, counts);
  else
  {
    std::vector<double> work(forest.n_active_cells(), 1.);
    for (std::size_t i = 0; i < cells.size(); ++i)
      work[cells[i]->active_cell_index()] += particle_cost * rows[width * (i + 1) - 1];
    soil.mesh.repartition(work);
  }
  soil.mesh.update();

  const std::vector<std::int64_t> planes = file.read_all<std::int64_t>("window", 2 * dim);
  Window<dim> window;
  std::copy_n(planes.begin(), dim, window.lower.begin());
  std::copy_n(planes.begin() + dim, dim, window.upper.begin());
  soil.mesh.set_window(window);
}

/// The particles of this rank lie next to each other in the file, as its leaves do.
template <int dim> void read_particles(const SoilParts<dim>& soil, const Hdf5Reader& file)
{
  constexpr unsigned int leaf_step = leaf_width<dim>, step = particle_width<dim>;
  const MPI_Comm communicator = soil.mesh.communicator();
  const Cells<dim> cells = cells_in_forest_order(soil.mesh);
  const std::vector<std::int64_t> leaves = read_leaves<dim>(file, cells, communicator);
  const auto in_leaf = [&](const std::size_t leaf) { return leaves[leaf_step * (leaf + 1) - 1]; };
  std::size_t count = 0;
  for (std::size_t i = 0; i < cells.size(); ++i)
    count += in_leaf(i);
  const std::size_t first = sum_over_lower_ranks(count, communicator);
  const std::vector<std::int64_t> ids = file.read_rows<std::int64_t>("particle numbers", 1, first, count);
  const std::vector<double> data = file.read_rows<double>("particles", step, first, count);

  auto& handler = soil.particles.edit();
  std::size_t p = 0;
  for (std::size_t i = 0; i < cells.size(); ++i)
    for (std::int64_t k = 0; k < in_leaf(i); ++k, ++p)
    {
      dealii::Point<dim> x;
      std::copy_n(&data[step * p], dim, x.begin_raw());
      handler.insert_particle(x, soil.mesh.mapping().transform_real_to_unit_cell(cells[i], x), ids[p], cells[i],
                              dealii::ArrayView<const double>(&data[step * p + dim], field::count));
    }
  handler.update_cached_numbers();
}

template <int dim> void read_contact(const SoilParts<dim>& soil, const Hdf5Reader& file)
{
  const MPI_Comm communicator = soil.mesh.communicator();
  // Any distribution serves: each record then goes to the rank of its particle.
  const auto keys = read_share<std::int64_t>(file, "contact keys", contact_key_width, communicator);
  const auto values = read_share<double>(file, "contact", contact_width, communicator);
  std::vector<ContactRecord> records;
  for (std::size_t i = 0; i < keys.size() / contact_key_width; ++i)
  {
    const std::int64_t* key = &keys[contact_key_width * i];
    const double* value = &values[contact_width * i];
    records.push_back({key[0],
                       static_cast<std::uint32_t>(key[1]),
                       static_cast<std::uint32_t>(key[2]),
                       {value[0], value[1], value[2]},
                       value[3],
                       value[4],
                       value[5] != 0.,
                       value[6],
                       {value[7], value[8], value[9], {value[10], value[11], value[12], value[13]}}});
  }
  soil.contact.import_history(records, all_ids(soil.particles));
}

void read_bodies(RigidSystems& bodies, const Hdf5Reader& file)
{
  const std::vector<double> rows = file.read_all<double>("rigid points", body_width);
  if (rows.size() != body_width * bodies.points.size())
    throw InputError("restart", "the restart file has another number of rigid points than this input",
                     "restart with the input of the first run");
  const double* row = rows.data();
  for (RigidPoint& point : bodies.points)
  {
    const auto take = [&row](auto&& x)
    {
      std::copy_n(row, x.size(), x.data());
      row += x.size();
    };
    take(point.pose.position);
    take(point.pose.rotation.coeffs());
    take(point.last_increment);
    take(point.velocity);
    take(point.acceleration);
  }
}

/// Rows and nodes meet on the rank that owns the place: the file tells no rank which rows are those of its nodes.
template <int dim> void read_prediction(const SoilParts<dim>& soil, const Hdf5Reader& file)
{
  using Vector = std::array<double, dim>;
  struct Row
  {
    NodeKey<dim> key;
    Vector increment;
  };
  const MPI_Comm communicator = soil.mesh.communicator();
  soil.prediction.reset();
  if (file.n_rows("prediction", node_width<dim>) == 0)
    return;
  const LeafTable<dim>& table = soil.mesh.leaves();
  const auto key_of = [&](const double* position) { return node_key<dim>(position, table.base_size); };
  const auto owner_of = [&](const NodeKey<dim>& key)
  { return std::max(0, table.find_owner(position_of<dim>(key, table.base_size))); };

  const int n_ranks = size_of(communicator);
  std::vector<std::vector<Row>> rows(n_ranks);
  const auto share = read_share<double>(file, "prediction", node_width<dim>, communicator);
  for (std::size_t i = 0; i < share.size(); i += node_width<dim>)
  {
    Row row{key_of(&share[i]), {}};
    std::copy_n(&share[i + dim], dim, row.increment.begin());
    rows[owner_of(row.key)].push_back(row);
  }
  std::vector<std::vector<NodeQuestion<NodeKey<dim>>>> questions(n_ranks);
  for (std::size_t node = 0; node < table.node_position.size(); ++node)
  {
    const NodeKey<dim> key = key_of(table.node_position[node].data());
    questions[owner_of(key)].push_back({node, key});
  }

  std::map<NodeKey<dim>, Vector> increment_at;
  for (const auto& part : exchange_between_ranks(rows, communicator))
    for (const Row& row : part)
      increment_at.emplace(row.key, row.increment);
  const auto find = [&](const NodeKey<dim>& key) -> std::optional<Vector>
  {
    const auto entry = increment_at.find(key);
    return entry == increment_at.end() ? std::nullopt : std::make_optional(entry->second);
  };
  std::vector<double>& increments = soil.prediction.emplace(dim * table.node_position.size(), 0.);
  ask_for_increments<dim>(questions, find, communicator, increments);
}
} // namespace

unsigned int step_of_checkpoint(const std::string& path)
{
  const Json progress = parse(Hdf5Reader(path, MPI_COMM_SELF).read_text("progress"), path);
  if (!progress.contains("step") || !progress["step"].is_number_unsigned())
    throw FileError(path, "is damaged: its progress is incomplete");
  return progress["step"];
}

template <int dim>
RunProgress read_checkpoint(Soil<dim>& soil, RigidSystems& bodies, const std::string& input, const std::string& path)
{
  const Hdf5Reader file(path, soil.communicator());
  const std::string version = file.read_text("version"), expected = version_text(dim);
  if (version != expected)
    throw FileError(path,
                    fmt::format("is \"{}\", but this program reads \"{}\"; restart with the program that wrote it",
                                version, expected));
  if (const std::string fields = file.read_text("particle fields"); fields != field_names())
    throw FileError(
        path, fmt::format("holds other fields of material points, {}; restart with the program that wrote it", fields));
  require_same_input(input, file.read_text("input"), path);
  require_same_surfaces(bodies, file.read_all<std::int64_t>("surfaces", surface_width), path);

  const SoilParts<dim> parts = soil.parts();
  read_mesh(parts, file);
  read_particles(parts, file);
  read_contact(parts, file);
  read_prediction(parts, file);
  read_bodies(bodies, file);
  const Json progress = parse(file.read_text("progress"), path);
  try
  {
    parts.n_deleted = progress.at("deleted");
    RunProgress result = progress_from(progress);
    result.program = file.read_text("program");
    return result;
  }
  catch (const Json::exception&)
  {
    throw FileError(path, "is damaged: its progress is incomplete; use an older restart file or start again");
  }
}

template RunProgress read_checkpoint<2>(Soil<2>&, RigidSystems&, const std::string&, const std::string&);
template RunProgress read_checkpoint<3>(Soil<3>&, RigidSystems&, const std::string&, const std::string&);
} // namespace kedge
