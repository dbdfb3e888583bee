// Tables in one HDF5 file. Entries are double, std::int64_t or char. Rank 0 writes for all, because MPI's files hang or
// crash where a disk is full; every rank reads for itself. Every function is collective, but no destructor is. A
// failure on one rank throws FileError on all.
#pragma once

#include <cstdint>
#include <mpi.h>
#include <string>
#include <vector>

namespace kedge
{
/// Writes under a second name, seals the file (seal.h) and renames it at the end, so a reader never sees an incomplete
/// file.
class Hdf5Writer
{
public:
  Hdf5Writer(std::string path, MPI_Comm communicator);
  /// Removes the draft of a file that was not finished.
  ~Hdf5Writer();
  Hdf5Writer(const Hdf5Writer&) = delete;
  Hdf5Writer& operator=(const Hdf5Writer&) = delete;

  /// Writes the rows of all ranks, of `width` entries each, one rank after the other.
  template <typename T> void write_rows(const std::string& name, const std::vector<T>& mine, unsigned int width);
  /// Writes the text that rank 0 gives.
  void write_text(const std::string& name, const std::string& text);
  /// Closes the file and gives it its name. The file that had the name before is called `kept` then, unless empty.
  void finish(const std::string& kept = "");

private:
  void open_draft();
  void close_draft();
  bool give_name(const std::string& kept) const;
  bool reserve(long long bytes);

  std::string path, draft;
  MPI_Comm communicator;
  std::int64_t file = -1; ///< of HDF5, on rank 0
  int descriptor = -1;    ///< of the same file, to reserve its space
  long long reserved = 0; ///< bytes for tables
  int reserve_error = 0;  ///< of the system
  bool sound = true;      ///< nothing has failed
};

class Hdf5Reader
{
public:
  /// Throws FileError where the file is missing, damaged or no HDF5 file.
  Hdf5Reader(std::string path, MPI_Comm communicator);
  ~Hdf5Reader();
  Hdf5Reader(const Hdf5Reader&) = delete;
  Hdf5Reader& operator=(const Hdf5Reader&) = delete;

  /// Number of rows of a table of this width.
  std::size_t n_rows(const std::string& name, unsigned int width) const;
  /// Rows `first` to `first` + `count`; each rank may ask for others.
  template <typename T>
  std::vector<T> read_rows(const std::string& name, unsigned int width, std::size_t first, std::size_t count) const;
  /// All rows, on every rank.
  template <typename T> std::vector<T> read_all(const std::string& name, unsigned int width) const;
  std::string read_text(const std::string& name) const;

private:
  void require(bool sound_here, const std::string& problem) const;

  std::string path;
  MPI_Comm communicator;
  std::int64_t file = -1;
};
} // namespace kedge
