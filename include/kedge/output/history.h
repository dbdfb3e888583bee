// Tables of numbers (CSV): one per moment and layer of particles, one growing table of the rigid bodies. Numbers have
// as many digits, up to 17, as it takes to read back the same value.
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

/// First the line "time,<time>", then the names of the columns, then the particles in the order of their numbers.
/// Throws FileError.
void write_particle_csv(const ParticleTable& table, const std::vector<ParticleField>& fields, double time,
                        const std::string& path);

/// The table of the rigid bodies: time, the fields of each point (body1_position_x, ...), the position of each tracked
/// node (track1_x, ...), force and couple of each joint (joint1_force_x, ...), stage and step; one row per output. Only
/// one rank may keep it.
class BodyHistory
{
public:
  BodyHistory(std::string path, std::vector<BodyField> fields);

  /// Takes over the rows of an earlier run up to and including `step`; an absent file is an empty table.
  void resume_after(unsigned int step);
  /// Adds a row, after the line of names if it is the first one, and hands it to the system. Throws FileError.
  void append(const RigidSystems& bodies, const std::vector<Vector6>& reactions, double time, unsigned int stage,
              unsigned int step);

private:
  std::string path;
  std::vector<BodyField> fields;
  std::ofstream file;
  std::string kept_names; ///< of an earlier run, until they were compared with this one's
};
} // namespace kedge
