#include <gtest/gtest.h>
#include <kedge/base/shared_array.h>

using namespace kedge;

TEST(SharedArray, GivesWhatTheOtherSideHasWritten)
{
  SharedArray<double> array("numbers", 3);
  array.overwrite_on_host()(1) = 2.;
  EXPECT_EQ(copy_to_host(array.read_on_device())(1), 2.);
  Kokkos::deep_copy(array.on_device(), 3.);
  EXPECT_EQ(array.read_on_host()(1), 3.);
  array.on_host()(2) = 4.;
  const auto seen = copy_to_host(array.on_device());
  EXPECT_EQ(seen(1), 3.);
  EXPECT_EQ(seen(2), 4.);
}

TEST(SharedArray, CopiesOnlyWhatHasChanged)
{
  SharedArray<double> array("numbers", 3);
  array.overwrite_on_host()(0) = 1.;
  const View<double*> device = array.read_on_device();
  Kokkos::deep_copy(device, 5.); // nobody has asked to write: the array does not know of it
  EXPECT_EQ(array.read_on_host()(0), !device_is_host || mirrors_apart() ? 1. : 5.);
}
