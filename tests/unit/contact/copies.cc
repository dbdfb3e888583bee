// What evaluations of contact copy between host and device, where mirrors are apart (KEDGE_MIRRORS_APART=1).
#include "pressed_block.h"
#include <gtest/gtest.h>
#include <kedge/replay/kernel_profile.h>

using namespace kedge;

TEST(ContactCopies, OfAnIterationAreNoLargerThanWhatBodiesHave)
{
  test::PressedBlock<3> block(0.4, 0.01);
  block.find_pairs(0.1);
  block.evaluate_at_rest(); // brings the pairs to the device
  const kedge::View<double*> increment = upload(block.increment, "increment");
  const Vector6 step = test::translation(1e-3, 0., -1e-3);

  const KernelProfiler counter(KernelWatch::none);
  block.contact.evaluate(block.bodies, {step}, increment);
  block.contact.loads();
  block.contact.load_tangents();
  block.contact.excess();
  block.contact.follow_path();
  const double in_iteration = copied_bytes(counter.profile());
  EXPECT_LE(in_iteration, sizeof(SurfaceMotion) + (6. + 36.) * sizeof(double));
  EXPECT_GT(block.contact.n_active(), 0);

  block.contact.commit(); // the history is the host's
  const double copied = copied_bytes(counter.profile()) - in_iteration;
  if (!device_is_host || mirrors_apart())
    EXPECT_GE(copied, 100. * sizeof(ContactPair));
  else
    EXPECT_EQ(copied, 0.);
}
