#include <filesystem>
#include <fstream>
#include <gtest/gtest.h>
#include <kedge/base/exceptions.h>
#include <kedge/replay/tensor_file.h>
#include <unistd.h>

namespace kedge
{
namespace
{
class TensorFile : public testing::Test
{
protected:
  void SetUp() override
  {
    path = (std::filesystem::temp_directory_path() / ("kedge-tensors-" + std::to_string(::getpid()))).string();
  }
  void TearDown() override { std::filesystem::remove(path); }

  void write()
  {
    for (std::size_t i = 0; i < rows.extent(0); ++i)
      for (std::size_t j = 0; j < 3; ++j)
        rows(i, j) = 10. * i + j;
    TensorWriter(path).write(
        [&](TensorWriter& file)
        {
          file("bytes", bytes);
          file("rows", rows);
          file("nothing", nothing);
          file("number", 7u);
        });
  }

  std::string path;
  const std::vector<unsigned char> bytes{1, 2, 3};
  const Kokkos::View<double* [3], Kokkos::HostSpace> rows { "rows", 4 };
  const std::vector<double> nothing;
};

TEST_F(TensorFile, ArraysComeBackInAnyOrder)
{
  write();
  TensorReader file(path);
  unsigned int number = 0;
  file("number", number);
  EXPECT_EQ(number, 7u);
  Kokkos::View<double* [3], Kokkos::LayoutLeft, Kokkos::HostSpace> other_layout;
  file("rows", other_layout);
  ASSERT_EQ(other_layout.extent(0), rows.extent(0));
  for (std::size_t i = 0; i < rows.extent(0); ++i)
    for (std::size_t j = 0; j < 3; ++j)
      EXPECT_EQ(other_layout(i, j), rows(i, j));
  std::vector<unsigned char> read_bytes;
  file("bytes", read_bytes);
  EXPECT_EQ(read_bytes, bytes);
  std::vector<double> read_nothing{1.};
  file("nothing", read_nothing);
  EXPECT_TRUE(read_nothing.empty());
}

/// Eight bytes of length, then JSON that says where numbers lie: what other programs rely on.
TEST_F(TensorFile, HasTheFormatOfSafetensors)
{
  write();
  std::ifstream file(path, std::ios::binary);
  std::uint64_t length = 0;
  file.read(reinterpret_cast<char*>(&length), 8);
  EXPECT_EQ(length % 8, 0u);
  std::string text(length, ' ');
  file.read(text.data(), static_cast<std::streamsize>(length));
  const nlohmann::json header = nlohmann::json::parse(text);
  EXPECT_EQ(header["rows"]["dtype"], "F64");
  EXPECT_EQ(header["rows"]["shape"], (std::vector<int>{4, 3}));
  const std::vector<std::size_t> offsets = header["rows"]["data_offsets"];
  EXPECT_EQ(offsets[1] - offsets[0], 4 * 3 * sizeof(double));
  double last = 0.;
  file.seekg(static_cast<std::streamoff>(8 + length + offsets[1] - sizeof(double)));
  file.read(reinterpret_cast<char*>(&last), sizeof(double));
  EXPECT_EQ(last, 32.);
}

TEST_F(TensorFile, DamageIsAnError)
{
  write();
  {
    TensorReader file(path);
    std::vector<double> values;
    EXPECT_THROW(file("missing", values), FileError);
    EXPECT_THROW(file("bytes", values), FileError); // another type
    Kokkos::View<double* [5], Kokkos::HostSpace> wide;
    EXPECT_THROW(file("rows", wide), FileError); // another width
  }
  std::filesystem::resize_file(path, std::filesystem::file_size(path) - 20);
  {
    TensorReader file(path);
    Kokkos::View<double* [3], Kokkos::HostSpace> read;
    EXPECT_THROW(file("rows", read), FileError);
  }
  std::ofstream(path) << "no header";
  EXPECT_THROW(TensorReader{path}, FileError);
  EXPECT_THROW(TensorReader{path + ".none"}, FileError);
}

TEST_F(TensorFile, AFolderThatIsMissingIsAnError)
{
  path += "/none/file";
  EXPECT_THROW(write(), FileError);
}
} // namespace
} // namespace kedge
