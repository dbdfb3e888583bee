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

/// All rows on rank 0, nothing elsewhere. Collective.
ParticleTable gather_on_root(const ParticleTable& mine, unsigned int n_columns, MPI_Comm communicator);

/// Writes the line "time,<time>", the names of the columns, and the particles in the order of their numbers. Throws
/// FileError.
void write_particle_csv(const ParticleTable& table, const std::vector<ParticleField>& fields, double time,
                        const std::string& path);

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
