#include "checkpointed_run.h"

#include <kedge/base/exceptions.h>

// Which files and which changes of the input a restart refuses.

namespace kedge
{
namespace
{
using test::checkpointed_input;
using test::Interrupted;

template <typename Dimension> class CheckpointRefusal : public test::CheckpointTest<Dimension>
{
};
TYPED_TEST_SUITE(CheckpointRefusal, test::CheckpointDimensions, test::DimensionName);

TYPED_TEST(CheckpointRefusal, IncompleteFileIsRefused)
{
  this->write();
  const auto size = std::filesystem::file_size(this->file);
  for (const std::uintmax_t bytes : {size - 1, size / 2, std::uintmax_t(100), std::uintmax_t(0)})
  {
    MPI_Barrier(MPI_COMM_WORLD);
    if (rank_of(MPI_COMM_WORLD) == 0)
      std::filesystem::resize_file(this->file, bytes);
    MPI_Barrier(MPI_COMM_WORLD);
    EXPECT_THROW(this->read(), FileError) << bytes;
  }
}

TYPED_TEST(CheckpointRefusal, MissingOrForeignFileIsRefused)
{
  EXPECT_THROW(this->read(), FileError);
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0)
    write_text_file(this->file, std::string(10000, 'x'));
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_THROW(this->read(), FileError);
}

TYPED_TEST(CheckpointRefusal, FileOfTheOtherDimensionIsRefused)
{
  constexpr int other = 5 - TypeParam::value;
  Interrupted<other>(MPI_COMM_WORLD).write(this->file);
  EXPECT_THROW(this->read(), FileError);
}

TYPED_TEST(CheckpointRefusal, FileOfAnotherVersionIsRefused)
{
  this->write();
  MPI_Barrier(MPI_COMM_WORLD);
  if (rank_of(MPI_COMM_WORLD) == 0)
  {
    std::string bytes = read_text_file(this->file);
    const std::string version = "Kedge restart file ";
    bytes[bytes.find(version) + version.size()] = '0';
    write_text_file(this->file, bytes);
  }
  MPI_Barrier(MPI_COMM_WORLD);
  EXPECT_THROW(this->read(), FileError);
}

TYPED_TEST(CheckpointRefusal, OtherInputIsRefusedByTheNameOfItsKey)
{
  this->write();
  std::string other = checkpointed_input;
  other.replace(other.find("10"), 2, "11");
  try
  {
    this->read(other);
    FAIL() << "accepted";
  }
  catch (const InputError& error)
  {
    EXPECT_NE(std::string(error.what()).find("/analysis/0/load steps"), std::string::npos) << error.what();
  }
}

TYPED_TEST(CheckpointRefusal, OtherOutputIsAccepted)
{
  this->write();
  std::string other = checkpointed_input;
  other.replace(other.find("\"on\""), 4, "\"off\"");
  EXPECT_NO_THROW(this->read(other));
}

TYPED_TEST(CheckpointRefusal, OtherCommentsAreAccepted)
{
  const auto with = [](const char* comment)
  { return std::string(R"({"comment": ")") + comment + R"(", "analysis": [{"comment": ")" + comment + R"("}]})"; };
  Interrupted<TypeParam::value>(MPI_COMM_WORLD).write(this->file, with("one"));
  EXPECT_NO_THROW(this->read(with("two")));
  EXPECT_NO_THROW(this->read(R"({"analysis": [{}]})"));
}

TYPED_TEST(CheckpointRefusal, TheLastStageMayEndLaterButNotEarlier)
{
  const auto until = [](const char* first, const char* last)
  { return std::string(R"({"analysis": [{"final time": )") + first + R"(}, {"final time": )" + last + "}]}"; };
  Interrupted<TypeParam::value>(MPI_COMM_WORLD).write(this->file, until("1.0", "3.0"));
  EXPECT_NO_THROW(this->read(until("1.0", "19.0")));
  EXPECT_THROW(this->read(until("1.0", "2.0")), InputError);
  EXPECT_THROW(this->read(until("2.0", "3.0")), InputError);
}

TYPED_TEST(CheckpointRefusal, AnExplicitStageMayEndLaterOnlyIfItsStepsKeepTheirLength)
{
  const auto until = [](const char* last, const char* step)
  {
    return std::string(R"({"analysis": [{"type": "explicit", "final time": )") + last + R"(, "basis step": )" + step +
           "}]}";
  };
  Interrupted<TypeParam::value>(MPI_COMM_WORLD).write(this->file, until("3.0", "0.01"));
  EXPECT_NO_THROW(this->read(until("19.0", "0.01")));
  Interrupted<TypeParam::value>(MPI_COMM_WORLD).write(this->file, until("3.0", "\"auto\""));
  EXPECT_THROW(this->read(until("19.0", "\"auto\"")), InputError);
}

} // namespace
} // namespace kedge
