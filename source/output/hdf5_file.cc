#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <fcntl.h>
#include <filesystem>
#include <hdf5.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>
#include <kedge/output/hdf5_file.h>
#include <kedge/output/seal.h>
#include <kedge/output/text_file.h>
#include <numeric>
#include <sys/resource.h>
#include <system_error>
#include <unistd.h>

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

/// Ranks read side by side, so the file needs no lock, which some file systems do not know.
hid_t make_access()
{
  const hid_t access = H5Pcreate(H5P_FILE_ACCESS);
#if H5_VERSION_GE(1, 10, 7)
  H5Pset_file_locking(access, false, true);
#endif
  return access;
}

/// Rows [first, first + count) of a table, and the memory that they go from or to.
struct Slice
{
  Slice(const hid_t table, const std::size_t first, const std::size_t count, const unsigned int width)
      : memory(make(count, width), H5Sclose)
  {
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

  Handle memory;
};

constexpr std::size_t message_size = std::size_t(1) << 26; // bytes of rows that travel at a time
constexpr long long room_for_headers = 1 << 20;            // bytes, more than a file needs beside its tables
} // namespace

Hdf5Writer::Hdf5Writer(std::string path_, const MPI_Comm communicator_)
    : path(std::move(path_)), draft(path + ".new"), communicator(communicator_)
{
  agree(communicator,
        [&]
        {
          if (rank_of(communicator) == 0)
            open_draft();
        });
}

Hdf5Writer::~Hdf5Writer()
{
  if (rank_of(communicator) != 0)
    return;
  close_draft();
  std::remove(draft.c_str()); // if it did not get its name
}

void Hdf5Writer::open_draft()
{
  const Silence silence;
  descriptor = ::open(draft.c_str(), O_RDWR | O_CREAT | O_TRUNC, 0666);
  if (descriptor < 0)
    throw FileError(draft, "cannot be opened for writing: " + last_system_message());
  if (reserve(0))
  {
    const Handle access(make_access(), H5Pclose);
    file = H5Fcreate(draft.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access);
  }
  if (file < 0)
  {
    close_draft();
    std::remove(draft.c_str());
    if (reserve_error == 0)
      throw FileError(draft, "cannot be created by HDF5");
    throw DiskError(draft, "cannot be written: " + std::generic_category().message(reserve_error));
  }
  sound = reserve(0); // creation gave the space back
}

/// Makes sure that so many more bytes fit on the disk. HDF5 must not meet a full one: it crashes as the program ends.
bool Hdf5Writer::reserve(const long long bytes)
{
  if (!sound)
    return false;
  reserved += bytes;
  const off_t wanted = reserved + room_for_headers;
  if (rlimit most{}; ::getrlimit(RLIMIT_FSIZE, &most) == 0 && most.rlim_cur < static_cast<rlim_t>(wanted))
  {
    reserve_error = EFBIG;
    return false;
  }
  reserve_error = ::fallocate(descriptor, FALLOC_FL_KEEP_SIZE, 0, wanted) == 0 ? 0 : errno;
  if (reserve_error == EOPNOTSUPP) // by the file system; filling the file tells at least what fits now
  {
    const off_t size = ::lseek(descriptor, 0, SEEK_END);
    reserve_error = posix_fallocate(descriptor, 0, wanted);
    if (::ftruncate(descriptor, size) != 0)
      reserve_error = errno;
  }
  return reserve_error == 0;
}

/// Rank 0 receives the rows of the others, a message at a time.
template <typename T>
void Hdf5Writer::write_rows(const std::string& name, const std::vector<T>& mine, const unsigned int width)
{
  const Silence silence;
  const int n_ranks = size_of(communicator);
  const std::size_t rows_at_once = std::max<std::size_t>(1, message_size / (width * sizeof(T)));
  const PlainType row(width * sizeof(T));
  const long long count = mine.size() / width;
  if (rank_of(communicator) != 0)
  {
    MPI_Gather(&count, 1, MPI_LONG_LONG, nullptr, 0, MPI_LONG_LONG, 0, communicator);
    for (std::size_t first = 0; first < std::size_t(count); first += rows_at_once)
      MPI_Send(&mine[first * width], std::min<std::size_t>(rows_at_once, count - first), row.get(), 0, 0, communicator);
    return;
  }
  std::vector<long long> counts(n_ranks);
  MPI_Gather(&count, 1, MPI_LONG_LONG, counts.data(), 1, MPI_LONG_LONG, 0, communicator);
  const std::size_t total = std::accumulate(counts.begin(), counts.end(), 0ll);
  sound = sound && reserve(total * width * sizeof(T));
  const Handle space(Slice::make(total, width), H5Sclose);
  const Handle table(
      !sound ? -1 : H5Dcreate2(file, name.c_str(), native_type(T()), space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT),
      H5Dclose);
  sound = sound && table >= 0;
  const auto write = [&](const std::size_t first, const std::size_t n, const T* rows)
  {
    const Slice slice(space, first, n, width);
    sound = sound && H5Dwrite(table, native_type(T()), slice.memory, space, H5P_DEFAULT, rows) >= 0;
  };
  if (count > 0) // HDF5 gives an empty table no space in the file
    write(0, count, mine.data());
  std::vector<T> received;
  std::size_t begin = count;
  for (int rank = 1; rank < n_ranks; begin += counts[rank++])
    for (std::size_t first = 0; first < std::size_t(counts[rank]); first += rows_at_once)
    {
      const std::size_t n = std::min<std::size_t>(rows_at_once, counts[rank] - first);
      received.resize(n * width);
      MPI_Recv(received.data(), n, row.get(), rank, 0, communicator, MPI_STATUS_IGNORE);
      write(begin + first, n, received.data());
    }
}

void Hdf5Writer::write_text(const std::string& name, const std::string& text)
{
  const bool root = rank_of(communicator) == 0;
  write_rows(name, root ? std::vector<char>(text.begin(), text.end()) : std::vector<char>(), 1);
}

/// Gives back the space that was reserved and not needed.
void Hdf5Writer::close_draft()
{
  const Silence silence;
  if (file >= 0 && H5Fclose(file) < 0)
    sound = false;
  if (descriptor >= 0)
  {
    const off_t size = ::lseek(descriptor, 0, SEEK_END);
    sound = sound && ::ftruncate(descriptor, size) == 0;
    ::close(descriptor);
  }
  file = descriptor = -1;
}

/// At no time is there no file of one of the two names, where the file system knows hard links.
bool Hdf5Writer::give_name(const std::string& kept) const
{
  if (!kept.empty() && ::access(path.c_str(), F_OK) == 0)
  {
    std::remove(kept.c_str());
    if (::link(path.c_str(), kept.c_str()) != 0 && std::rename(path.c_str(), kept.c_str()) != 0)
      return false;
  }
  if (std::rename(draft.c_str(), path.c_str()) != 0)
    return false;
  sync_folder(std::filesystem::path(path).parent_path().string());
  return true;
}

void Hdf5Writer::finish(const std::string& kept)
{
  agree(communicator,
        [&]
        {
          if (rank_of(communicator) != 0)
            return;
          close_draft();
          if (sound)
            seal(draft);
          if (sound && give_name(kept))
            return;
          std::remove(draft.c_str());
          throw DiskError(path, "could not be written in full, the one before is kept");
        });
}

Hdf5Reader::Hdf5Reader(std::string path_, const MPI_Comm communicator_)
    : path(std::move(path_)), communicator(communicator_)
{
  agree(communicator,
        [&]
        {
          if (rank_of(communicator) == 0)
            require_sealed(path);
        });
  const Silence silence;
  const Handle access(make_access(), H5Pclose);
  file = H5Fopen(path.c_str(), H5F_ACC_RDONLY, access);
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
  require(H5Dread(table, native_type(T()), slice.memory, space, H5P_DEFAULT, rows.data()) >= 0,
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
