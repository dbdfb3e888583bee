// Tables of numbers (CSV): one per moment and layer of particles, and one growing table of the rigid bodies. Numbers
// have the fewest digits (at most 17) that read back as the same value.
#pragma once

#include <fstream>
#include <kedge/output/fields.h>
#include <mpi.h>

namespace kedge
{
/// Rows of values, each with the number of its particle.
struct ParticleTable
{
  std::vector<long long> ids;
  std::vector<double> values; ///< row by row
};

ParticleTable tabulate(const std::vector<ParticleView>& particles, const std::vector<ParticleField>& fields);

/// Writes the line "time,<time>", the names of the columns, and the particles of all ranks in the order of their
/// numbers. Each rank sorts a range of the numbers and appends its rows in turn, so none has all rows. Throws FileError
/// on all ranks. Collective.
void write_particle_csv(const ParticleTable& mine, const std::vector<ParticleField>& fields, double time,
                        const std::string& path, MPI_Comm communicator);

/// The table of the rigid bodies: time, the fields of each point (body1_position_x, ...), the position of each tracked
/// node (track1_x, ...), force and couple of each joint (joint1_force_x, ...), stage and step; one row per output. Only
/// one rank may have it.
class BodyHistory
{
public:
  BodyHistory(std::string path, std::vector<BodyField> fields);

  /// Keeps the rows of an earlier run up to and including `step`. A missing file counts as an empty table.
  void resume_after(unsigned int step);
  /// Adds a row and flushes it to the system. Writes the line of names before the first row. Throws FileError.
  void append(const RigidSystems& bodies, const std::vector<Vector6>& reactions, double time, unsigned int stage,
              unsigned int step);

private:
  std::string path;
  std::vector<BodyField> fields;
  std::ofstream file;
  std::string kept_names; ///< names of an earlier run, until they are compared with those of this run
};
} // namespace kedge
