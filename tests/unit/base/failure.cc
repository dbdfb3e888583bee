#include <gtest/gtest.h>
#include <kedge/base/communication.h>
#include <kedge/base/exceptions.h>
#include <kedge/base/failure.h>

namespace kedge
{
namespace
{
const MPI_Comm world = MPI_COMM_WORLD;

bool is_last() { return rank_of(world) == size_of(world) - 1; }

/// What a rank other than the last says of an error of the last one; alone, a rank needs no number.
std::string prefix() { return size_of(world) > 1 ? "rank " + std::to_string(size_of(world) - 1) + ": " : ""; }

/// The message with which all ranks throw an Error where the last one does.
template <typename Error, typename Thrown> std::string agreed(const Thrown& thrown)
{
  try
  {
    agree(world,
          [&]
          {
            if (is_last())
              throw thrown;
          });
  }
  catch (const Error& error)
  {
    EXPECT_TRUE(fails_everywhere("test"));
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Agreement, AllRanksThrowTheErrorOfOne)
{
  EXPECT_EQ(agreed<SolverError>(SolverError("too stiff")), prefix() + "too stiff");
  EXPECT_EQ(agreed<FileError>(FileError("a.vtu", "is full")), prefix() + "a.vtu: is full");
  EXPECT_EQ(agreed<InputError>(InputError("x", "is wrong", "do y")), prefix() + "x: is wrong; do y");
}

TEST(Agreement, DiskErrorStaysOne)
{
  EXPECT_EQ(agreed<DiskError>(DiskError("a.vtu", "is full")), prefix() + "a.vtu: is full");
}

TEST(Agreement, DiskErrorHidesNoOtherOne)
{
  if (size_of(world) == 1)
    GTEST_SKIP() << "one rank has one error";
  const auto fail = []
  {
    if (is_last())
      throw SolverError("too stiff");
    throw DiskError("a.vtu", "is full");
  };
  EXPECT_THROW(agree(world, fail), SolverError);
}

TEST(Agreement, WorkThatTheDiskRefusesIsLeft)
{
  const auto write = [](const bool fits)
  {
    agree(world,
          [&]
          {
            if (is_last() && !fits)
              throw DiskError("a.vtu", "is full");
          });
  };
  EXPECT_EQ(try_to_write("test", [&] { write(true); }), "");
  EXPECT_EQ(try_to_write("test", [&] { write(false); }), prefix() + "a.vtu: is full");
  EXPECT_THROW(try_to_write("test", [] { throw FileError("a.vtu", "is not yours"); }), FileError);
}

TEST(Agreement, OtherErrorsBecomeOneThatIsNamed)
{
  if (size_of(world) == 1)
    GTEST_SKIP() << "one rank needs no agreement";
  EXPECT_NE(agreed<ProgramError>(std::bad_alloc()).find("too little memory"), std::string::npos);
  EXPECT_NE(agreed<ProgramError>(std::out_of_range("7")).find("mistake in the program"), std::string::npos);
}

TEST(Agreement, PathIsSentToo)
{
  try
  {
    agree(world,
          [&]
          {
            if (is_last())
              throw FileError("a.vtu", "is full");
          });
    FAIL() << "nothing was thrown";
  }
  catch (const FileError& error)
  {
    EXPECT_EQ(error.path, "a.vtu");
  }
}

TEST(Agreement, WhatAllRanksSayNamesNone)
{
  try
  {
    agree(world, [&] { throw SolverError("no gravity"); });
    FAIL() << "nothing was thrown";
  }
  catch (const SolverError& error)
  {
    EXPECT_STREQ(error.what(), "no gravity");
  }
}

TEST(Agreement, TheFirstOfManyIsHeard)
{
  if (size_of(world) == 1)
    GTEST_SKIP() << "one rank needs no agreement";
  try
  {
    agree(world, [&] { throw SolverError(std::to_string(rank_of(world))); });
    FAIL() << "nothing was thrown";
  }
  catch (const SolverError& error)
  {
    EXPECT_STREQ(error.what(), "rank 0: 0");
  }
}

TEST(Agreement, WorkThatSucceedsIsDone)
{
  int done = 0;
  EXPECT_NO_THROW(agree(world, [&] { ++done; }));
  EXPECT_EQ(done, 1);
}

TEST(Failures, HaveTheExitCodesOfTheProgram)
{
  const auto code_of = [](const auto& error)
  {
    try
    {
      throw error;
    }
    catch (...)
    {
      return current_failure().code;
    }
  };
  EXPECT_EQ(code_of(InputError("x", "wrong")), bad_input);
  EXPECT_EQ(code_of(SolverError("x")), solver_failure);
  EXPECT_EQ(code_of(FileError("x", "full")), file_failure);
  EXPECT_EQ(code_of(std::bad_alloc()), mistake);
  EXPECT_EQ(code_of(7), mistake);
}
} // namespace
} // namespace kedge
