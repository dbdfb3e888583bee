// Tables of numbers (CSV): one per moment and layer of particles, and one growing table of the rigid bodies. Numbers
// have the fewest digits (at most 17) that read back as the same value.
#pragma once

#include <kedge/output/fields.h>
#include <mpi.h>
#include <utility>

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
/// numbers. Each rank sorts a range of the numbers and appends its rows in turn, so none has all rows. The file gets
/// its name when it is complete. Throws FileError on all ranks. Collective.
void write_particle_csv(const ParticleTable& mine, const std::vector<ParticleField>& fields, double time,
                        const std::string& path, MPI_Comm communicator);

/// Names of the columns of the table of the rigid bodies: time, the fields of each point (body1_position_x, ...), the
/// position of each tracked node (track1_x, ...), force and couple of each joint (joint1_force_x, ...), stage and step.
std::vector<std::string> history_columns(const RigidSystems& bodies, const std::vector<BodyField>& fields);

/// The table of the rigid bodies, one row per output. Rows that the disk does not take wait in memory for the next
/// attempt, `most_bytes` of them; later ones are lost. Only one rank may have it.
class BodyHistory
{
public:
  BodyHistory(std::string path, std::vector<BodyField> fields, std::size_t most_bytes = std::size_t(1) << 24);

  /// Keeps the rows of an earlier run up to and including `step`. A missing file counts as an empty table.
  void resume_after(unsigned int step);
  /// Adds a row, hands it to the system and writes the line of names before the first one. A table of an earlier run
  /// with other columns gets another name. Throws FileError.
  void append(const RigidSystems& bodies, const std::vector<Vector6>& reactions, double time, unsigned int stage,
              unsigned int step);
  /// Writes the rows that wait. Throws FileError.
  void write();
  /// Rows that are not in the file.
  unsigned int count_waiting() const;
  /// Where the rows of an earlier run are whose columns are others, if that was found since this was asked last.
  std::string take_earlier_table() { return std::exchange(earlier_table, {}); }
  /// Rows that are lost since this was asked last.
  unsigned int take_lost() { return std::exchange(n_lost, 0); }

private:
  void set_aside();

  std::string path;
  std::vector<BodyField> fields;
  std::size_t most_bytes;
  std::string line_of_names; ///< empty before the first row
  std::string waiting;       ///< rows
  unsigned int n_lost = 0;
  bool is_begun = false; ///< whether the file is of this run, or of one that it goes on from
  std::string earlier_table;
  std::string kept_names; ///< names of an earlier run, until they are compared with those of this run
};
} // namespace kedge
