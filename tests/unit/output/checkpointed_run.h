#pragma once
// States of runs that the tests of checkpoints write and read.

#include "../particles/soil_block.h"
#include "read_back.h"

#include <gtest/gtest.h>
#include <kedge/output/checkpoint.h>

namespace kedge::test
{
inline constexpr double particle_cost = 20.;
inline const std::string checkpointed_input =
    R"({"domain": {"size": 2.0}, "analysis": [{"load steps": 10}], "output": {"vtk": "on"}})";

inline RigidSystems two_points()
{
  RigidSystems bodies;
  bodies.points.resize(2);
  return bodies;
}

/// Everything that a run keeps between two steps, initially empty.
template <int dim> struct Fresh
{
  explicit Fresh(const MPI_Comm communicator_)
      : communicator(communicator_),
        mesh(communicator, SoilBlock<dim>::layout()),
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
template <int dim> struct Interrupted : SoilBlock<dim>
{
  explicit Interrupted(const MPI_Comm communicator) : SoilBlock<dim>(communicator), contact({}, communicator)
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
        records.push_back(
            {id, corner, 1, {noise(id, 2), -noise(id, 3), noise(id, corner)}, -noise(id, 4), noise(id, 5)});
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
        prediction.push_back(noise_at(x, dim, d));
    progress = {2, {4096, 12345, 64, 3, 2, 4, true}, 77, 15, 4, true, "a {\"summary\"} with umlauts: ä"};
  }

  RunState<dim> state() { return {this->mesh, this->particles, bodies, contact, prediction, progress}; }

  RigidSystems bodies = two_points();
  Contact<dim> contact;
  std::vector<double> prediction;
  RunProgress progress;
};

template <typename Dimension> class CheckpointTest : public testing::Test
{
public:
  static constexpr int dim = Dimension::value;

protected:
  /// Writes the state of an interrupted run on all ranks.
  void write() { write_checkpoint(Interrupted<dim>(MPI_COMM_WORLD).state(), checkpointed_input, file); }
  /// Reads it on all ranks, with the input that wrote it unless told otherwise.
  void read(const std::string& other_input = checkpointed_input)
  {
    Fresh<dim> run(MPI_COMM_WORLD);
    read_checkpoint(run.state(), other_input, file, particle_cost);
  }

  const TemporaryFolder folder;
  const std::string file = folder / "run.restart";
};

using CheckpointDimensions = testing::Types<std::integral_constant<int, 2>, std::integral_constant<int, 3>>;
} // namespace kedge::test
