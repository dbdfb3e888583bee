#include <cstdio>
#include <hdf5.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/output/hdf5_file.h>

namespace kedge
{
namespace
{
/// Closes an HDF5 object when it goes out of scope. A negative number stands for an object that could not be created.
class Handle
{
public:
  Handle(hid_t id, herr_t (*close)(hid_t)) : id(id), close(close) {}
  ~Handle()
  {
    if (id >= 0)
      close(id);
  }
  Handle(const Handle&) = delete;
  Handle& operator=(const Handle&) = delete;
  operator hid_t() const { return id; }

private:
  hid_t id;
  herr_t (*close)(hid_t);
};

/// Stops HDF5 from printing its call stack at every failure; here failures become FileErrors.
class Silence
{
public:
  Silence()
  {
    H5Eget_auto2(H5E_DEFAULT, &print, &data);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  }
  ~Silence() { H5Eset_auto2(H5E_DEFAULT, print, data); }

private:
  H5E_auto2_t print = nullptr;
  void* data = nullptr;
};

hid_t native_type(double) { return H5T_NATIVE_DOUBLE; }
hid_t native_type(std::int64_t) { return H5T_NATIVE_INT64; }
hid_t native_type(char) { return H5T_NATIVE_CHAR; }

bool on_all_ranks(const bool here, const MPI_Comm communicator) { return min_over_ranks(here, communicator) > 0.; }

/// Opens or creates a file for all ranks.
template <typename Open> hid_t open_together(const MPI_Comm communicator, const Open& open)
{
  const Silence silence;
  const Handle access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
  H5Pset_fapl_mpio(access, communicator, MPI_INFO_NULL);
  return open(access);
}

/// The part of a table that this rank transfers: rows [first, first + count).
struct Slice
{
  Slice(const hid_t table, const std::size_t first, const std::size_t count, const unsigned int width)
      : memory(make(count, width), H5Sclose), transfer(H5Pcreate(H5P_DATASET_XFER), H5Pclose)
  {
    H5Pset_dxpl_mpio(transfer, H5FD_MPIO_COLLECTIVE);
    const hsize_t start[2] = {first, 0}, size[2] = {count, width};
    if (count > 0)
      H5Sselect_hyperslab(table, H5S_SELECT_SET, start, nullptr, size, nullptr);
    else
    {
      H5Sselect_none(table);
      H5Sselect_none(memory);
    }
  }

  static hid_t make(const std::size_t rows, const unsigned int width)
  {
    const hsize_t size[2] = {rows, width};
    return H5Screate_simple(2, size, nullptr);
  }

  Handle memory, transfer;
};
} // namespace

Hdf5Writer::Hdf5Writer(std::string path_, const MPI_Comm communicator_)
    : path(std::move(path_)), draft(path + ".new"), communicator(communicator_)
{
  file = open_together(communicator, [&](const hid_t access)
                       { return H5Fcreate(draft.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access); });
  if (!on_all_ranks(file >= 0, communicator))
    throw FileError(draft, "cannot be opened for writing");
}

Hdf5Writer::~Hdf5Writer()
{
  if (file < 0)
    return;
  const Silence silence;
  H5Fclose(file);
  if (rank_of(communicator) == 0)
    std::remove(draft.c_str());
}

template <typename T>
void Hdf5Writer::write_rows(const std::string& name, const std::vector<T>& mine, const unsigned int width)
{
  const Silence silence;
  const long long count = mine.size() / width;
  const long long total = sum_over_ranks(count, communicator);
  const Handle space(Slice::make(total, width), H5Sclose);
  const Handle table(H5Dcreate2(file, name.c_str(), native_type(T()), space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
                     H5Dclose);
  if (table < 0)
    sound = false;
  if (total == 0) // HDF5 gives an empty table no space in the file
    return;
  const Slice slice(space, sum_over_lower_ranks(count, communicator), count, width);
  if (H5Dwrite(table, native_type(T()), slice.memory, space, slice.transfer, mine.data()) < 0)
    sound = false;
}

void Hdf5Writer::write_text(const std::string& name, const std::string& text)
{
  const bool root = rank_of(communicator) == 0;
  write_rows(name, root ? std::vector<char>(text.begin(), text.end()) : std::vector<char>(), 1);
}

void Hdf5Writer::finish()
{
  const Silence silence;
  if (H5Fclose(file) < 0)
    sound = false;
  file = -1;
  sound = on_all_ranks(sound, communicator);
  // No rank may still be writing when the file gets its name.
  if (rank_of(communicator) == 0)
  {
    sound = sound && std::rename(draft.c_str(), path.c_str()) == 0;
    if (!sound)
      std::remove(draft.c_str());
  }
  if (!on_all_ranks(sound, communicator))
    throw FileError(path, "could not be written in full; check that the disk has free space");
}

Hdf5Reader::Hdf5Reader(std::string path_, const MPI_Comm communicator_)
    : path(std::move(path_)), communicator(communicator_)
{
  file = open_together(communicator, [&](const hid_t access) { return H5Fopen(path.c_str(), H5F_ACC_RDONLY, access); });
  require(file >= 0, "cannot be opened: it is missing, incomplete or no HDF5 file");
}

Hdf5Reader::~Hdf5Reader()
{
  if (file >= 0)
    H5Fclose(file);
}

void Hdf5Reader::require(const bool sound_here, const std::string& problem) const
{
  if (!on_all_ranks(sound_here, communicator))
    throw FileError(path, problem);
}

std::size_t Hdf5Reader::n_rows(const std::string& name, const unsigned int width) const
{
  const Silence silence;
  const Handle table(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose);
  hsize_t size[2] = {0, 0};
  bool sound = table >= 0;
  if (sound)
  {
    const Handle space(H5Dget_space(table), H5Sclose);
    sound = H5Sget_simple_extent_ndims(space) == 2 && H5Sget_simple_extent_dims(space, size, nullptr) == 2;
  }
  require(sound && size[1] == width, "has no table \"" + name + "\" of " + std::to_string(width) + " columns");
  return size[0];
}

template <typename T>
std::vector<T> Hdf5Reader::read_rows(const std::string& name, const unsigned int width, const std::size_t first,
                                     const std::size_t count) const
{
  const Silence silence;
  const std::size_t n = n_rows(name, width);
  require(first + count <= n, "has too few rows in its table \"" + name + "\"");
  std::vector<T> rows(count * width);
  if (n == 0)
    return rows;
  const Handle table(H5Dopen2(file, name.c_str(), H5P_DEFAULT), H5Dclose), space(H5Dget_space(table), H5Sclose);
  const Slice slice(space, first, count, width);
  require(H5Dread(table, native_type(T()), slice.memory, space, slice.transfer, rows.data()) >= 0,
          "cannot be read at its table \"" + name + "\"");
  return rows;
}

template <typename T> std::vector<T> Hdf5Reader::read_all(const std::string& name, const unsigned int width) const
{
  return read_rows<T>(name, width, 0, n_rows(name, width));
}

std::string Hdf5Reader::read_text(const std::string& name) const
{
  const std::vector<char> text = read_all<char>(name, 1);
  return {text.begin(), text.end()};
}

template void Hdf5Writer::write_rows(const std::string&, const std::vector<double>&, unsigned int);
template void Hdf5Writer::write_rows(const std::string&, const std::vector<std::int64_t>&, unsigned int);
template std::vector<double> Hdf5Reader::read_rows(const std::string&, unsigned int, std::size_t, std::size_t) const;
template std::vector<std::int64_t> Hdf5Reader::read_rows(const std::string&, unsigned int, std::size_t,
                                                         std::size_t) const;
template std::vector<double> Hdf5Reader::read_all(const std::string&, unsigned int) const;
template std::vector<std::int64_t> Hdf5Reader::read_all(const std::string&, unsigned int) const;
} // namespace kedge
