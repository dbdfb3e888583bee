#include "read_back.h"

#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/history.h>

namespace kedge
{
namespace
{
using test::own;
using test::TemporaryFolder;

TEST(ParticleCsv, TextIsExact)
{
  const TemporaryFolder folder;
  const auto fields = select_particle_fields<3>({"position", "volume"});
  const ParticleTable table = {{7, 3}, {1., -2.5e-3, 0.1, 1e300, 1. / 3., 0., 1e-7, std::nan("")}};
  write_particle_csv(table, fields, 0.25, folder / own("mps.csv"), MPI_COMM_SELF);
  EXPECT_EQ(read_text_file(folder / own("mps.csv")), "time,0.25\n"
                                                     "position_x,position_y,position_z,volume\n"
                                                     "0.3333333333333333,0,1e-07,nan\n"
                                                     "1,-0.0025,0.1,1e+300\n");
}

TEST(ParticleCsv, NumbersReadBackExactly)
{
  const TemporaryFolder folder;
  const double value = 0.1 + 0.2;
  write_particle_csv({{0}, {value}}, select_particle_fields<3>({"volume"}), 0., folder / own("mps.csv"), MPI_COMM_SELF);
  const std::string text = read_text_file(folder / own("mps.csv"));
  EXPECT_EQ(std::stod(text.substr(text.find("volume\n") + 7)), value);
}

TEST(ParticleCsv, LayerWithoutParticlesHasHeaderOnly)
{
  const TemporaryFolder folder;
  write_particle_csv({}, select_particle_fields<3>({"volume"}), 1., folder / own("mps.csv"), MPI_COMM_SELF);
  EXPECT_EQ(read_text_file(folder / own("mps.csv")), "time,1\nvolume\n");
}

TEST(ParticleCsv, RowsOfAllRanksAreInOrder)
{
  const TemporaryFolder folder;
  const long long rank = rank_of(MPI_COMM_WORLD), size = size_of(MPI_COMM_WORLD);
  ParticleTable mine;
  for (long long i = 4; i-- > rank;) // another number on each rank, interleaved and backwards
  {
    mine.ids.push_back(size * i + rank);
    mine.values.push_back(double(size * i + rank));
  }
  write_particle_csv(mine, select_particle_fields<3>({"volume"}), 0., folder / "mps.csv", MPI_COMM_WORLD);
  std::string expected = "time,0\nvolume\n";
  for (long long id = 0; id < 4 * size; ++id)
    if (id / size >= id % size)
      expected += std::to_string(id) + "\n";
  EXPECT_EQ(read_text_file(folder / "mps.csv"), expected);
}

TEST(ParticleCsv, FailureOfOneRankIsThatOfAll)
{
  ParticleTable mine{{1}, {1.}};
  EXPECT_THROW(write_particle_csv(mine, select_particle_fields<3>({"volume"}), 0., "/nowhere/mps.csv", MPI_COMM_WORLD),
               FileError);
}

/// Two points, the second one turned by half a turn about z and carrying a tracked node.
RigidSystems two_points()
{
  RigidSystems bodies;
  bodies.points.resize(2);
  bodies.points[0].mass = 5.;
  bodies.points[1].mass = 6.5;
  bodies.points[1].pose.position = {1., 2., 3.};
  bodies.points[1].pose.rotation = Eigen::Quaterniond(0., 0., 0., 1.);
  bodies.tracked.push_back({Eigen::Vector3d(0.5, 0., 0.25), 1});
  return bodies;
}

TEST(BodyCsv, TextIsExact)
{
  const TemporaryFolder folder;
  BodyHistory history(folder / own("rigid_body.csv"), select_body_fields({"mass", "reaction force"}));
  std::vector<Vector6> reactions(2, Vector6::Zero());
  reactions[1] << 1., -2., 0.5, 9., 9., 9.;
  history.append(two_points(), reactions, 0.125, 1, 2);
  history.append(two_points(), {}, 0.25, 2, 13);
  EXPECT_EQ(read_text_file(folder / own("rigid_body.csv")),
            "time,body1_mass,body1_reaction force_x,body1_reaction force_y,body1_reaction force_z,"
            "body2_mass,body2_reaction force_x,body2_reaction force_y,body2_reaction force_z,"
            "track1_x,track1_y,track1_z,stage,step\n"
            "0.125,5,0,0,0,6.5,1,-2,0.5,0.5,2,3.25,1,2\n"
            "0.25,5,0,0,0,6.5,0,0,0,0.5,2,3.25,2,13\n");
}

TEST(BodyCsv, JointsStandAfterTrackedNodes)
{
  const TemporaryFolder folder;
  RigidSystems bodies = two_points();
  Joint ball;
  ball.points = {0, 1};
  ball.anchors = {Eigen::Vector3d::Zero(), Eigen::Vector3d::Zero()};
  ball.stiffness = 4.;
  bodies.joints = {ball};
  BodyHistory history(folder / own("rigid_body.csv"), {});
  history.append(bodies, {}, 0.125, 1, 2);
  EXPECT_EQ(read_text_file(folder / own("rigid_body.csv")),
            "time,track1_x,track1_y,track1_z,joint1_force_x,joint1_force_y,joint1_force_z,"
            "joint1_couple_x,joint1_couple_y,joint1_couple_z,stage,step\n"
            "0.125,0.5,2,3.25,4,8,12,0,0,0,1,2\n");
}

TEST(BodyCsv, NewRunReplacesTheOldTable)
{
  const TemporaryFolder folder;
  for (int run = 0; run < 2; ++run)
  {
    BodyHistory history(folder / own("rigid_body.csv"), {});
    history.append({}, {}, 0.5, 1, 2 + run);
  }
  EXPECT_EQ(read_text_file(folder / own("rigid_body.csv")), "time,stage,step\n0.5,1,3\n");
}

TEST(BodyCsv, RestartDropsLaterAndTornRows)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("rigid_body.csv");
  write_text_file(path, "time,stage,step\n0.1,1,2\n0.2,1,3\n0.3,1,4\n0.4,1");
  BodyHistory history(path, {});
  history.resume_after(3);
  history.append({}, {}, 0.25, 1, 4);
  EXPECT_EQ(read_text_file(path), "time,stage,step\n0.1,1,2\n0.2,1,3\n0.25,1,4\n");
}

TEST(BodyCsv, RestartWithoutTableStartsOne)
{
  const TemporaryFolder folder;
  BodyHistory history(folder / own("rigid_body.csv"), {});
  history.resume_after(3);
  history.append({}, {}, 0.25, 1, 4);
  EXPECT_EQ(read_text_file(folder / own("rigid_body.csv")), "time,stage,step\n0.25,1,4\n");
}

TEST(BodyCsv, RestartWithOtherColumnsSetsTheTableAside)
{
  const TemporaryFolder folder;
  const std::string path = folder / own("rigid_body.csv");
  const std::string earlier = "time,body1_mass,body2_mass,stage,step\n0.1,5,6,1,2\n";
  write_text_file(path, earlier);
  BodyHistory history(path, {});
  history.resume_after(2);
  history.append({}, {}, 0.25, 1, 3);
  EXPECT_EQ(read_text_file(path), "time,stage,step\n0.25,1,3\n");
  const std::string aside = history.take_earlier_table();
  EXPECT_EQ(aside, path.substr(0, path.size() - 4) + "-1.csv");
  EXPECT_EQ(read_text_file(aside), earlier);
  EXPECT_EQ(history.take_earlier_table(), "");
}

TEST(BodyCsv, UnwritableFileIsNamed)
{
  BodyHistory history("/no such folder/rigid_body.csv", {});
  try
  {
    history.append({}, {}, 0., 1, 2);
    FAIL() << "no error";
  }
  catch (const FileError& error)
  {
    EXPECT_EQ(error.path, "/no such folder/rigid_body.csv");
  }
}
} // namespace
} // namespace kedge
