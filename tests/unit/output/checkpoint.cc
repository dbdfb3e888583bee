#include "../particles/soil_block.h"
#include "read_back.h"

#include <cstring>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/checkpoint.h>
#include <kedge/particles/splitting.h>
#include <set>

namespace kedge
{
namespace
{
using test::noise;
using test::TemporaryFolder;

constexpr double particle_cost = 20.;
const std::string input = R"({"domain": {"size": 2.0}, "analysis": [{"load steps": 10}], "output": {"vtk": "on"}})";

RigidSystems two_points()
{
  RigidSystems bodies;
  bodies.points.resize(2);
  return bodies;
}

/// Everything that a run keeps between two steps, empty at first.
template <int dim> struct Fresh
{
  explicit Fresh(const MPI_Comm communicator_)
      : communicator(communicator_),
        mesh(communicator, test::SoilBlock<dim>::layout()),
        particles(mesh),
        contact({}, communicator)
  {
  }

  RunState<dim> state() { return {mesh, particles, bodies, contact, prediction, progress}; }

  MPI_Comm communicator;
  BackgroundMesh<dim> mesh;
  ParticleSet<dim> particles;
  RigidSystems bodies = two_points();
  Contact<dim> contact;
  std::vector<double> prediction;
  RunProgress progress;
};

/// A run in the middle of a stage: refined cells, disturbed particles, some of them waiting outside the window.
template <int dim> struct Interrupted : test::SoilBlock<dim>
{
  explicit Interrupted(const MPI_Comm communicator) : test::SoilBlock<dim>(communicator), contact({}, communicator)
  {
    this->refine(false);
    this->disturb();
    Window<dim> window = this->mesh.leaves().window;
    window.upper[0] -= 1;
    this->mesh.set_window(window);
    this->particles.load();

    std::vector<ContactRecord> records;
    for (const long long id : this->particles.ids())
      for (std::uint32_t corner = 0; corner < 2 && noise(id, 1) < 0.4; ++corner)
        records.push_back({id,
                           corner,
                           1,
                           {noise(id, 2), -noise(id, 3), noise(id, corner)},
                           -noise(id, 4),
                           noise(id, 5),
                           noise(id, 6) < 0.5});
    contact.import_history(records, this->particles.ids());

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
    for (const auto& x : this->mesh.leaves().node_position)
      for (unsigned int d = 0; d < dim; ++d)
        prediction.push_back(test::noise_at(x, dim, d));
    progress = {2, {4096, 12345, 64, 3, 2, 4, true}, 77, 15, 4, true, "a {\"summary\"} with umlauts: ä"};
  }

  RunState<dim> state() { return {this->mesh, this->particles, bodies, contact, prediction, progress}; }

  RigidSystems bodies = two_points();
  Contact<dim> contact;
  std::vector<double> prediction;
  RunProgress progress;
};

/// The contact history of all ranks, in order.
template <int dim> std::vector<ContactRecord> history(const Contact<dim>& contact, const MPI_Comm communicator)
{
  std::vector<ContactRecord> all = gather_everywhere(contact.export_history(), communicator);
  std::sort(all.begin(), all.end(),
            [](const auto& a, const auto& b)
            { return std::tie(a.particle, a.corner, a.surface) < std::tie(b.particle, b.corner, b.surface); });
  return all;
}

template <typename Record> bool same_bytes(const std::vector<Record>& a, const std::vector<Record>& b)
{
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(Record)) == 0;
}

/// Particles of all ranks in the order of their numbers, each with the corner and the size of its cell.
template <int dim>
std::vector<std::array<double, 2 * dim + 2 + field::count>> rows(const ParticleSet<dim>& particles,
                                                                 const MPI_Comm communicator)
{
  std::vector<std::array<double, 2 * dim + 2 + field::count>> mine;
  for (const auto& particle : particles.handler())
  {
    auto& row = mine.emplace_back();
    const auto& cell = particle.get_surrounding_cell();
    row[0] = particle.get_id();
    row[1] = cell->level();
    for (unsigned int d = 0; d < dim; ++d)
    {
      row[2 + d] = particle.get_location()[d];
      row[2 + dim + d] = cell->vertex(0)[d];
    }
    std::copy_n(particle.get_properties().data(), field::count, row.begin() + 2 + 2 * dim);
  }
  auto all = gather_everywhere(mine, communicator);
  std::sort(all.begin(), all.end(), [](const auto& a, const auto& b) { return a[0] < b[0]; });
  return all;
}

/// The first `n` ranks, for as long as the object lives.
class FirstRanks
{
public:
  explicit FirstRanks(const int n) : inside(rank_of(MPI_COMM_WORLD) < n)
  {
    MPI_Comm_split(MPI_COMM_WORLD, inside, 0, &communicator);
  }
  ~FirstRanks() { MPI_Comm_free(&communicator); }
  FirstRanks(const FirstRanks&) = delete;
  FirstRanks& operator=(const FirstRanks&) = delete;

  bool inside;
  MPI_Comm communicator;
};

template <typename Dimension> class Checkpoint : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

protected:
  /// Writes the state of an interrupted run on all ranks and reads it again, with another input if told.
  void write() { write_checkpoint(Interrupted<dim>(MPI_COMM_WORLD).state(), input, file); }
  void read(const std::string& other_input = input)
  {
    Fresh<dim> run(MPI_COMM_WORLD);
    read_checkpoint(run.state(), other_input, file, particle_cost);
  }

  const TemporaryFolder folder;
  const std::string file = folder / "run.restart";
};

using Dimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
TYPED_TEST_SUITE(Checkpoint, Dimensions, test::DimensionName);

TYPED_TEST(Checkpoint, StateIsTheSameOnAnyNumbersOfRanks)
{
  constexpr int dim = TypeParam::value;
  const BackgroundMesh<dim> first_mesh(MPI_COMM_WORLD, test::SoilBlock<dim>::layout()); // starts p4est on all ranks
  const int size = size_of(MPI_COMM_WORLD);
  for (int writers = 1; writers <= size; ++writers)
    for (int readers = 1; readers <= size; ++readers)
    {
      SCOPED_TRACE(fmt::format("from {} to {} ranks", writers, readers));
      const FirstRanks writing(writers), reading(readers);
      Interrupted<dim> run(writing.communicator); // ranks that do not write have one of their own
      std::vector<ContactRecord> expected_contact;
      decltype(rows(run.particles, writing.communicator)) expected_particles;
      if (writing.inside)
      {
        write_checkpoint(run.state(), input, this->file);
        expected_contact = history(run.contact, writing.communicator);
        expected_particles = rows(run.particles, writing.communicator);
        EXPECT_GT(expected_contact.size(), 10u);
      }
      MPI_Barrier(MPI_COMM_WORLD);
      Fresh<dim> restored(reading.communicator);
      if (!reading.inside)
        continue;
      read_checkpoint(restored.state(), input, this->file, particle_cost);

      const auto contact = history(restored.contact, reading.communicator);
      const auto particles = rows(restored.particles, reading.communicator);
      if (writing.inside)
      {
        EXPECT_TRUE(same_bytes(contact, expected_contact));
        EXPECT_TRUE(same_bytes(particles, expected_particles));
      }
      const std::set<long long> here(restored.particles.ids().begin(), restored.particles.ids().end());
      for (const ContactRecord& record : restored.contact.export_history())
        EXPECT_TRUE(here.count(record.particle));

      EXPECT_TRUE(restored.mesh.leaves().window == run.mesh.leaves().window);
      std::vector<double> expected;
      for (const auto& x : restored.mesh.leaves().node_position)
        for (unsigned int d = 0; d < dim; ++d)
          expected.push_back(test::noise_at(x, dim, d));
      EXPECT_EQ(restored.prediction, expected);
      for (unsigned int i = 0; i < 2; ++i)
      {
        const RigidPoint &point = restored.bodies.points[i], &of_run = run.bodies.points[i];
        EXPECT_EQ(point.pose.position, of_run.pose.position);
        EXPECT_EQ(point.pose.rotation.coeffs(), of_run.pose.rotation.coeffs());
        EXPECT_EQ(point.last_increment, of_run.last_increment);
        EXPECT_EQ(point.velocity, of_run.velocity);
        EXPECT_EQ(point.acceleration, of_run.acceleration);
      }
    }
}

TYPED_TEST(Checkpoint, EachRankGetsItsOwnCellsBack)
{
  constexpr int dim = TypeParam::value;
  Interrupted<dim> run(MPI_COMM_WORLD);
  write_checkpoint(run.state(), input, this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  read_checkpoint(restored.state(), input, this->file, particle_cost);
  EXPECT_TRUE(same_bytes(rows(restored.particles, MPI_COMM_SELF), rows(run.particles, MPI_COMM_SELF)));
  EXPECT_EQ(std::multiset<long long>(restored.particles.ids().begin(), restored.particles.ids().end()),
            std::multiset<long long>(run.particles.ids().begin(), run.particles.ids().end()));
  EXPECT_EQ(restored.mesh.leaves().n_global_nodes, run.mesh.leaves().n_global_nodes);
  EXPECT_EQ(restored.mesh.leaves().node_ids.size(), run.mesh.leaves().node_ids.size());
}

TYPED_TEST(Checkpoint, RestoredRunGoesOnAsTheFirst)
{
  constexpr int dim = TypeParam::value;
  Interrupted<dim> run(MPI_COMM_WORLD);
  write_checkpoint(run.state(), input, this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  read_checkpoint(restored.state(), input, this->file, particle_cost);
  const auto go_on = [](const RunState<dim>& state)
  {
    state.particles.carry_through([&] { state.mesh.triangulation().refine_global(1); });
    state.contact.inherit(split_particles(state.particles, state.mesh, 2)); // new numbers follow the largest
    state.particles.load();
    state.contact.follow_particles(state.particles.ids());
  };
  go_on(run.state());
  go_on(restored.state());
  EXPECT_TRUE(same_bytes(rows(restored.particles, MPI_COMM_WORLD), rows(run.particles, MPI_COMM_WORLD)));
  EXPECT_TRUE(same_bytes(history(restored.contact, MPI_COMM_WORLD), history(run.contact, MPI_COMM_WORLD)));
}

TYPED_TEST(Checkpoint, ProgressIsKept)
{
  constexpr int dim = TypeParam::value;
  Interrupted<dim> run(MPI_COMM_WORLD);
  write_checkpoint(run.state(), input, this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  read_checkpoint(restored.state(), input, this->file, particle_cost);
  const RunProgress& progress = restored.progress;
  EXPECT_EQ(progress.stage, 2u);
  EXPECT_EQ(progress.clock.ticks_per_step, 4096);
  EXPECT_EQ(progress.clock.position, 12345);
  EXPECT_EQ(progress.clock.limit, 64);
  EXPECT_EQ(progress.clock.cuts, 3u);
  EXPECT_EQ(progress.clock.made, 2u);
  EXPECT_EQ(progress.clock.patience, 4u);
  EXPECT_TRUE(progress.clock.on_trial);
  EXPECT_EQ(progress.step, 77u);
  EXPECT_EQ(progress.steps_in_stage, 15u);
  EXPECT_EQ(progress.deleted, 4);
  EXPECT_TRUE(progress.has_warned_of_window);
  EXPECT_EQ(progress.summary, run.progress.summary);
}

TYPED_TEST(Checkpoint, LostParticlesCountAsDeleted)
{
  constexpr int dim = TypeParam::value;
  Interrupted<dim> run(MPI_COMM_WORLD);
  ParticleIncrements increments;
  increments.displacement = View<double* [3]>("displacement", run.particles.ids().size());
  increments.deformation_gradient = View<double* [9]>("dF", run.particles.ids().size());
  Kokkos::deep_copy(increments.displacement, 100.); // beyond the grid
  run.particles.commit(increments, DomainUpdate::none);
  run.particles.load();
  run.contact.import_history({}, run.particles.ids());
  ASSERT_GT(run.particles.n_lost(), 0);
  write_checkpoint(run.state(), input, this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  read_checkpoint(restored.state(), input, this->file, particle_cost);
  EXPECT_EQ(restored.progress.deleted, 4 + run.particles.n_lost());
}

TYPED_TEST(Checkpoint, NoPredictionStaysNone)
{
  Interrupted<TypeParam::value> run(MPI_COMM_WORLD);
  run.prediction.clear();
  write_checkpoint(run.state(), input, this->file);
  Fresh<TypeParam::value> restored(MPI_COMM_WORLD);
  restored.prediction = {1.};
  read_checkpoint(restored.state(), input, this->file, particle_cost);
  EXPECT_TRUE(restored.prediction.empty());
}

TYPED_TEST(Checkpoint, IncompleteFileIsRefused)
{
  this->write();
  const auto size = std::filesystem::file_size(this->file);
  for (const std::uintmax_t bytes : {size - 1, size / 2, std::uintmax_t(100), std::uintmax_t(0)})
  {
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank_of(MPI_COMM_WORLD) == 0)
      std::filesystem::resize_file(this->file, bytes);
    MPI_Barrier(MPI_COMM_WORLD);
    EXPECT_THROW(this->read(), FileError) << bytes;
  }
}

TYPED_TEST(Checkpoint, MissingOrForeignFileIsRefused)
{
  EXPECT_THROW(this->read(), FileError);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0)
    write_text_file(this->file, std::string(10000, 'x'));
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_THROW(this->read(), FileError);
}

TYPED_TEST(Checkpoint, FileOfTheOtherDimensionIsRefused)
{
  constexpr int other = 5 - TypeParam::value;
  write_checkpoint(Interrupted<other>(MPI_COMM_WORLD).state(), input, this->file);
  EXPECT_THROW(this->read(), FileError);
}

TYPED_TEST(Checkpoint, FileOfAnotherVersionIsRefused)
{
  this->write();
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0)
  {
    std::string bytes = read_text_file(this->file);
    const std::string version = "Kedge restart file ";
    bytes[bytes.find(version) + version.size()] = '9';
    write_text_file(this->file, bytes);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_THROW(this->read(), FileError);
}

TYPED_TEST(Checkpoint, OtherInputIsRefusedByTheNameOfItsKey)
{
  this->write();
  std::string other = input;
  other.replace(other.find("10"), 2, "11");
  try
  {
    this->read(other);
    FAIL() << "accepted";
  }
  catch (const InputError& error)
  {
    EXPECT_NE(std::string(error.what()).find("/analysis/0/load steps"), std::string::npos) << error.what();
  }
}

TYPED_TEST(Checkpoint, OtherOutputIsAccepted)
{
  this->write();
  std::string other = input;
  other.replace(other.find("\"on\""), 4, "\"off\"");
  EXPECT_NO_THROW(this->read(other));
}

TYPED_TEST(Checkpoint, TheLastStageMayEndLaterThanItWasToButNotEarlier)
{
  const auto until = [](const char* first, const char* last)
  { return std::string(R"({"analysis": [{"final time": )") + first + R"(}, {"final time": )" + last + "}]}"; };
  write_checkpoint(Interrupted<TypeParam::value>(MPI_COMM_WORLD).state(), until("1.0", "3.0"), this->file);
  EXPECT_NO_THROW(this->read(until("1.0", "19.0")));
  EXPECT_THROW(this->read(until("1.0", "2.0")), InputError);
  EXPECT_THROW(this->read(until("2.0", "3.0")), InputError);
}

TYPED_TEST(Checkpoint, AnExplicitStageMayEndLaterOnlyIfItsStepsStayAsLong)
{
  const auto until = [](const char* last, const char* step)
  {
    return std::string(R"({"analysis": [{"type": "explicit", "final time": )") + last + R"(, "basis step": )" + step +
           "}]}";
  };
  write_checkpoint(Interrupted<TypeParam::value>(MPI_COMM_WORLD).state(), until("3.0", "0.01"), this->file);
  EXPECT_NO_THROW(this->read(until("19.0", "0.01")));
  write_checkpoint(Interrupted<TypeParam::value>(MPI_COMM_WORLD).state(), until("3.0", "\"auto\""), this->file);
  EXPECT_THROW(this->read(until("19.0", "\"auto\"")), InputError);
}

TYPED_TEST(Checkpoint, ReplacesTheFileAndLeavesNoDraft)
{
  if (rank_of(MPI_COMM_WORLD) == 0)
    write_text_file(this->file, "old");
  MPI_Barrier(MPI_COMM_WORLD);
  this->write();
  EXPECT_NO_THROW(this->read());
  EXPECT_FALSE(std::filesystem::exists(this->file + ".new"));
}

TYPED_TEST(Checkpoint, FolderThatIsMissingIsAnError)
{
  Interrupted<TypeParam::value> run(MPI_COMM_WORLD);
  EXPECT_THROW(write_checkpoint(run.state(), input, this->folder / "missing/run.restart"), FileError);
}
} // namespace
} // namespace kedge
