#include <gtest/gtest.h>
#include <kedge/base/environment.h>

int main(int argc, char** argv)
{
  kedge::Environment environment(argc, argv);
  testing::InitGoogleTest(&argc, argv);
  if (environment.rank() != 0) // one report is enough; failures still set the exit code of every rank
    delete testing::UnitTest::GetInstance()->listeners().Release(
        testing::UnitTest::GetInstance()->listeners().default_result_printer());
  return RUN_ALL_TESTS();
}
