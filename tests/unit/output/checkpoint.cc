#include "checkpointed_run.h"

#include <cstring>
#include <fmt/format.h>
#include <kedge/base/exceptions.h>
#include <kedge/particles/splitting.h>
#include <set>
#include <sys/resource.h>

// What a checkpoint brings back.

namespace kedge
{
namespace
{
using test::checkpointed_input;
using test::Fresh;
using test::Interrupted;

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

template <typename Dimension> class Checkpoint : public test::CheckpointTest<Dimension>
{
};
TYPED_TEST_SUITE(Checkpoint, test::CheckpointDimensions, test::DimensionName);

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
        run.write(this->file);
        expected_contact = history(run.contact, writing.communicator);
        expected_particles = rows(run.particles, writing.communicator);
        EXPECT_GT(expected_contact.size(), 10u);
      }
      MPI_Barrier(MPI_COMM_WORLD);
      Fresh<dim> restored(reading.communicator);
      if (!reading.inside)
        continue;
      restored.read(this->file, checkpointed_input);

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
      EXPECT_EQ(restored.soil.prediction(), expected);
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
  run.write(this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  restored.read(this->file, checkpointed_input);
  EXPECT_TRUE(same_bytes(rows(restored.particles, MPI_COMM_SELF), rows(run.particles, MPI_COMM_SELF)));
  EXPECT_EQ(std::multiset<long long>(restored.particles.ids().begin(), restored.particles.ids().end()),
            std::multiset<long long>(run.particles.ids().begin(), run.particles.ids().end()));
  EXPECT_EQ(restored.mesh.leaves().n_global_nodes, run.mesh.leaves().n_global_nodes);
  EXPECT_EQ(restored.mesh.leaves().node_ids.size(), run.mesh.leaves().node_ids.size());
}

TYPED_TEST(Checkpoint, RestoredRunContinuesLikeTheFirst)
{
  constexpr int dim = TypeParam::value;
  Interrupted<dim> run(MPI_COMM_WORLD);
  run.write(this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  restored.read(this->file, checkpointed_input);
  const auto go_on = [](const SoilParts<dim>& soil)
  {
    soil.particles.carry_through([&] { soil.mesh.triangulation().refine_global(1); });
    soil.contact.inherit(split_particles(soil.particles, soil.mesh, 2), {}); // new numbers follow the largest
    soil.contact.follow_particles(all_ids(soil.particles));
  };
  go_on(run.soil.parts());
  go_on(restored.soil.parts());
  EXPECT_TRUE(same_bytes(rows(restored.particles, MPI_COMM_WORLD), rows(run.particles, MPI_COMM_WORLD)));
  EXPECT_TRUE(same_bytes(history(restored.contact, MPI_COMM_WORLD), history(run.contact, MPI_COMM_WORLD)));
}

TYPED_TEST(Checkpoint, ProgressIsKept)
{
  constexpr int dim = TypeParam::value;
  Interrupted<dim> run(MPI_COMM_WORLD);
  run.write(this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  restored.read(this->file, checkpointed_input);
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
  EXPECT_EQ(progress.newton.overshoots, 0.625);
  EXPECT_EQ(progress.newton.at_rest, 72.5);
  EXPECT_EQ(restored.soil.n_deleted(), 4);
  EXPECT_TRUE(progress.has_warned_of_window);
  EXPECT_EQ(progress.summary, run.progress.summary);
}

TYPED_TEST(Checkpoint, LostParticlesCountAsDeleted)
{
  constexpr int dim = TypeParam::value;
  Interrupted<dim> run(MPI_COMM_WORLD);
  run.move([](long long, unsigned int) { return 100.; }); // beyond the grid
  run.contact.import_history({}, run.particles.ids());
  ASSERT_GT(run.particles.lost().number, 0);
  run.write(this->file);
  Fresh<dim> restored(MPI_COMM_WORLD);
  restored.read(this->file, checkpointed_input);
  EXPECT_EQ(restored.soil.n_deleted(), 4 + run.particles.lost().number);
}

TYPED_TEST(Checkpoint, NoPredictionStaysNone)
{
  Interrupted<TypeParam::value> run(MPI_COMM_WORLD);
  run.soil.forget_prediction();
  run.write(this->file);
  Fresh<TypeParam::value> restored(MPI_COMM_WORLD);
  restored.soil.parts().prediction.emplace(1, 1.);
  restored.read(this->file, checkpointed_input);
  EXPECT_FALSE(restored.soil.prediction());
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
  EXPECT_THROW(run.write(this->folder / "missing/run.restart"), FileError);
}

TYPED_TEST(Checkpoint, FullDiskKeepsTheFileBefore)
{
  this->write();
  rlimit before{};
  getrlimit(RLIMIT_FSIZE, &before);
  const rlimit tight{1 << 16, before.rlim_max};
  setrlimit(RLIMIT_FSIZE, &tight);
  EXPECT_THROW(this->write(), FileError);
  setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_NO_THROW(this->read());
  EXPECT_FALSE(std::filesystem::exists(this->file + ".new"));
}
} // namespace
} // namespace kedge
