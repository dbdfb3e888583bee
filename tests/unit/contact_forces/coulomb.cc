#include <Eigen/Dense>
#include <gtest/gtest.h>
#include <kedge/contact_forces/coulomb.h>
#include <random>
#include <string>
#include <tuple>

using namespace kedge;

namespace
{
using Eigen::Matrix3d;
using Eigen::Vector3d;

/// A soil point against the plane z = 0, a concave edge along t or a vertex, both at the origin, or a patch that bends
/// away from z = 0 there, with a body at rest.
struct Body
{
  std::string name;
  int held; ///< directions that the closest point cannot follow: 1 face, 2 edge, 3 vertex; 0: a patch

  ContactGeometry at(const Vector3d& x, const Vector3d& start, const double reference) const
  {
    const Vector3d edge = Vector3d(1., 2., 0.5).normalized();
    ContactGeometry geometry;
    geometry.slip = x - start;
    geometry.turning.setZero();
    if (held == 0)
    {
      Matrix3d bend = Matrix3d::Zero();
      bend.topLeftCorner<2, 2>() << 20., 5., 5., -10.;
      const Vector3d gradient = Vector3d::UnitZ() + bend * x;
      geometry.steepness = gradient.norm();
      geometry.normal = gradient / geometry.steepness;
      geometry.turning =
          (Matrix3d::Identity() - geometry.normal * geometry.normal.transpose()) * bend / geometry.steepness;
      geometry.gap = x[2] + 0.5 * x.dot(bend * x);
    }
    else if (held == 1)
    {
      geometry.normal = Vector3d::UnitZ();
      geometry.gap = x[2];
    }
    else
    {
      Matrix3d subspace = Matrix3d::Identity();
      if (held == 2)
        subspace -= edge * edge.transpose();
      const Vector3d offset = subspace * x;
      geometry.gap = -offset.norm();
      geometry.normal = offset / geometry.gap;
      geometry.turning = (subspace - geometry.normal * geometry.normal.transpose()) / geometry.gap;
    }
    geometry.gap -= reference;
    return geometry;
  }
};

std::ostream& operator<<(std::ostream& out, const Body& body) { return out << body.name; }

class Coulomb : public testing::TestWithParam<Body>
{
public:
  Vector3d random_vector(const double size)
  {
    std::uniform_real_distribution<double> uniform(-1., 1.);
    return size * Vector3d(uniform(generator), uniform(generator), uniform(generator));
  }

  /// A point that presses: inside the half space, or anywhere near the edge or vertex.
  Vector3d random_point()
  {
    Vector3d x = random_vector(1e-2);
    if (GetParam().held <= 1)
      x[2] = -std::abs(x[2]) - (GetParam().held == 1 ? 1e-4 : 3e-3);
    return x;
  }

  /// Largest difference between the tangent and differences of the force, over the normal stiffness; points whose
  /// neighbours are on another branch of the law do not count.
  double worst_tangent(const ContactStiffness& stiffness, const double reference, const bool want_sliding,
                       const double multiplier = 0., const bool bonded = false)
  {
    double worst = 0.;
    unsigned int compared = 0;
    for (unsigned int n = 0; n < 1000; ++n)
    {
      const Vector3d x = random_point(), start = x + random_vector(5e-3);
      const Vector3d previous = random_vector(1e3);
      const auto respond = [&](const Vector3d& y)
      { return respond_to_contact(GetParam().at(y, start, reference), stiffness, previous, multiplier, bonded); };
      const auto branch = [&](const Vector3d& y)
      {
        const ContactResponse response = respond(y);
        const double pressure = multiplier - stiffness.normal * GetParam().at(y, start, reference).gap;
        const SlipLimit limit = slip_limit(stiffness, pressure, bonded);
        return std::make_tuple(response.active, response.sliding, limit.slope);
      };
      const double step = 1e-5 * x.norm();
      const ContactResponse response = respond(x);
      if (!response.active || response.sliding != want_sliding || GetParam().at(x, start, 0.).gap > -1e-3)
        continue;
      Matrix3d differences;
      bool smooth = true;
      for (int j = 0; j < 3; ++j)
      {
        const ContactResponse ahead = respond(x + step * Vector3d::Unit(j)),
                              behind = respond(x - step * Vector3d::Unit(j));
        for (const double side : {-step, step})
          smooth = smooth && branch(x + side * Vector3d::Unit(j)) == branch(x);
        differences.col(j) = (ahead.force - behind.force) / (2. * step);
      }
      if (!smooth)
        continue;
      ++compared;
      worst = std::max(worst, (response.tangent - differences).lpNorm<Eigen::Infinity>() / stiffness.normal);
    }
    EXPECT_GT(compared, 100u);
    return worst;
  }

private:
  std::mt19937 generator{1};
};

INSTANTIATE_TEST_SUITE_P(, Coulomb,
                         testing::Values(Body{"face", 1}, Body{"edge", 2}, Body{"vertex", 3}, Body{"patch", 0}),
                         [](const auto& info) { return info.param.name; });
} // namespace

TEST_P(Coulomb, TangentWithoutFriction) { EXPECT_LT(worst_tangent({1e6, 5e5, 0.}, 0., false), 1e-6); }

TEST_P(Coulomb, TangentWithAReferenceGap) { EXPECT_LT(worst_tangent({1e6, 5e5, 0.}, -5e-4, false), 1e-6); }

TEST_P(Coulomb, TangentWithAMultiplier)
{
  EXPECT_LT(worst_tangent({1e6, 5e5, 0.}, 0., false, 2e3), 1e-6);
  EXPECT_LT(worst_tangent({1e6, 5e5, 0.3}, -5e-4, true, 2e3), 1e-6);
}

TEST_P(Coulomb, TangentInStick) { EXPECT_LT(worst_tangent({1e6, 5e5, 10.}, 0., false), 1e-6); }

TEST_P(Coulomb, TangentInSlip) { EXPECT_LT(worst_tangent({1e6, 5e5, 0.3}, 0., true), 1e-6); }

TEST_P(Coulomb, TangentInSlipByTheAdhesion)
{
  EXPECT_LT(worst_tangent({1e6, 5e5, 0.3, 500., TangentialLimit::smaller}, 0., true), 1e-6);
}

TEST_P(Coulomb, TangentInSlipByTheSum)
{
  EXPECT_LT(worst_tangent({1e6, 5e5, 0.1, 500., TangentialLimit::sum}, 0., true), 1e-6);
}

TEST_P(Coulomb, TangentWhereTheAdhesionRisesWithThePressure)
{
  EXPECT_LT(worst_tangent({1e6, 5e7, 0.1, 1e6, TangentialLimit::sum}, 0., true), 1e-4);
}

TEST_P(Coulomb, TangentInStickByTheAdhesionAlone)
{
  EXPECT_LT(worst_tangent({1e6, 5e5, 0., 1e5, TangentialLimit::sum}, 0., false), 1e-6);
}

TEST_P(Coulomb, TangentOfABondedPoint)
{
  using Limit = TangentialLimit;
  constexpr double off = -2e-2, half_off = -6e-3; // reference gaps: all points pull, or some do
  for (const double reference : {off, half_off})
    for (const double multiplier : {0., -2e3})
    {
      EXPECT_LT(worst_tangent({1e6, 5e5, 0.3, 500., Limit::smaller}, reference, true, multiplier, true), 1e-6);
      EXPECT_LT(worst_tangent({1e6, 5e5, 0.3, 1e5, Limit::smaller}, reference, false, multiplier, true), 1e-6);
      EXPECT_LT(worst_tangent({1e6, 5e5, 0.3, 500., Limit::sum}, reference, true, multiplier, true), 1e-6);
      EXPECT_LT(worst_tangent({1e6, 5e5, 0.3, 1e5, Limit::sum}, reference, false, multiplier, true), 1e-6);
      EXPECT_LT(worst_tangent({1e6, 5e5, 0., 0., Limit::friction}, reference, false, multiplier, true), 1e-6);
    }
}

TEST_P(Coulomb, ForceStaysInTheFrictionCone)
{
  const ContactStiffness stiffness{1e6, 5e5, 0.4};
  for (unsigned int n = 0; n < 1000; ++n)
  {
    const Vector3d x = random_point();
    const ContactGeometry geometry = GetParam().at(x, x + random_vector(1e-2), 0.);
    const ContactResponse response = respond_to_contact(geometry, stiffness, random_vector(1e4));
    const double pressure = response.force.dot(geometry.normal);
    EXPECT_NEAR(pressure, -stiffness.normal * geometry.gap, 1e-12 * pressure);
    EXPECT_LE(response.tangential.norm(), 0.4 * pressure * (1. + 1e-12));
    EXPECT_NEAR(response.tangential.dot(geometry.normal), 0., 1e-12 * pressure);
    EXPECT_LT((response.force - pressure * geometry.normal - response.tangential).norm(), 1e-12 * pressure);
  }
}

TEST_P(Coulomb, SlidingForceOpposesTheSlip)
{
  const ContactStiffness stiffness{1e6, 5e5, 0.01};
  for (unsigned int n = 0; n < 100; ++n)
  {
    const Vector3d x = random_point();
    const ContactGeometry geometry = GetParam().at(x, x + random_vector(1e-2), 0.);
    const ContactResponse response = respond_to_contact(geometry, stiffness, Vector3d::Zero());
    if (response.sliding)
    {
      EXPECT_LT(response.force.dot(geometry.slip - geometry.slip.dot(geometry.normal) * geometry.normal), 0.);
    }
  }
}

TEST(CoulombLaw, NothingActsAcrossAGap)
{
  const Body face{"face", 1};
  for (const double gap : {0., 1e-12, 1.})
  {
    const ContactResponse response =
        respond_to_contact(face.at({0., 0., gap}, {1., 0., gap}, 0.), {1e6, 5e5, 0.4}, {1., 2., 3.});
    EXPECT_FALSE(response.active);
    EXPECT_EQ(response.force.norm(), 0.);
    EXPECT_EQ(response.tangential.norm(), 0.);
    EXPECT_EQ(response.tangent.norm(), 0.);
  }
}

TEST(CoulombLaw, StickAddsToWhatWasThere)
{
  const Body face{"face", 1};
  const ContactResponse response =
      respond_to_contact(face.at({1e-3, 0., -1e-2}, {0., 0., -1e-2}, 0.), {1e6, 5e5, 0.4}, {0., 200., 0.});
  EXPECT_FALSE(response.sliding);
  EXPECT_NEAR(response.force[0], -500., 1e-9);
  EXPECT_NEAR(response.force[1], 200., 1e-9);
  EXPECT_NEAR(response.force[2], 1e4, 1e-9);
}

TEST(CoulombLaw, SlipIsReachedAtTheConesEdge)
{
  const Body face{"face", 1};
  const ContactStiffness stiffness{1e6, 5e5, 0.4}; // 4 kN at a gap of -1 cm: 8 mm of slip
  EXPECT_FALSE(
      respond_to_contact(face.at({7.99e-3, 0., -1e-2}, {0., 0., -1e-2}, 0.), stiffness, Vector3d::Zero()).sliding);
  EXPECT_TRUE(
      respond_to_contact(face.at({8.01e-3, 0., -1e-2}, {0., 0., -1e-2}, 0.), stiffness, Vector3d::Zero()).sliding);
}

TEST(CoulombLaw, AReferenceGapMovesTheSurface)
{
  const Body face{"face", 1};
  EXPECT_FALSE(respond_to_contact(face.at({0., 0., -1e-2}, {0., 0., -1e-2}, -1e-2), {1e6, 5e5, 0.4}, {}).active);
  EXPECT_NEAR(
      respond_to_contact(face.at({0., 0., -1.1e-2}, {0., 0., 0.}, -1e-2), {1e6, 5e5, 0.}, Vector3d::Zero()).force[2],
      1e3, 1e-9);
}

TEST(ContactResponse, AMultiplierPressesWhereTheCornerJustTouches)
{
  const Body face{"face", 1};
  const ContactStiffness stiffness{1e6, 5e5, 0.};
  const auto pressure = [&](const double gap) {
    return respond_to_contact(face.at({0., 0., gap}, {0., 0., gap}, 0.), stiffness, Vector3d::Zero(), 2e3).force[2];
  };
  EXPECT_DOUBLE_EQ(pressure(0.), 2e3);
  EXPECT_DOUBLE_EQ(pressure(-1e-3), 3e3);
  EXPECT_DOUBLE_EQ(pressure(1e-3), 1e3); // it lets go only where the spring has taken it back
  EXPECT_EQ(pressure(2.1e-3), 0.);
}

TEST(SlipLimits, FollowTheirForms)
{
  using Limit = TangentialLimit;
  const auto limit = [](const Limit form, const double pressure, const bool bonded = false) {
    return slip_limit({1e6, 5e5, 0.4, 100., form}, pressure, bonded).force;
  };
  EXPECT_DOUBLE_EQ(limit(Limit::friction, 1e3), 400.);
  EXPECT_DOUBLE_EQ(limit(Limit::smaller, 1e3), 100.);
  EXPECT_DOUBLE_EQ(limit(Limit::smaller, 200.), 80.);
  EXPECT_DOUBLE_EQ(limit(Limit::sum, 1e3), 500.);
  EXPECT_DOUBLE_EQ(limit(Limit::sum, 10.), 104.);
  EXPECT_DOUBLE_EQ(limit(Limit::sum, 5.), 52.); // rises from zero to all of the adhesion
  EXPECT_DOUBLE_EQ(limit(Limit::sum, -1.), 0.);
  EXPECT_DOUBLE_EQ(limit(Limit::friction, -1e3, true), 0.);
  EXPECT_DOUBLE_EQ(limit(Limit::smaller, -1e3, true), 100.);
  EXPECT_DOUBLE_EQ(limit(Limit::smaller, 200., true), 100.);
  EXPECT_DOUBLE_EQ(limit(Limit::sum, -1e3, true), 100.);
  EXPECT_DOUBLE_EQ(limit(Limit::sum, 200., true), 180.);
}

TEST(BondedPoint, PullsAsItPresses)
{
  const Body face{"face", 1};
  const ContactStiffness stiffness{1e6, 5e5, 0.};
  for (const double gap : {-1e-3, 0., 1e-3})
  {
    const ContactResponse response =
        respond_to_contact(face.at({0., 0., gap}, {0., 0., gap}, 0.), stiffness, Vector3d::Zero(), 0., true);
    EXPECT_TRUE(response.active);
    EXPECT_DOUBLE_EQ(response.force[2], -1e6 * gap);
  }
}

TEST(SlipLimits, LetTheForceBeContinuousWhereThePressureEnds)
{
  const Body face{"face", 1};
  for (const TangentialLimit form : {TangentialLimit::friction, TangentialLimit::smaller, TangentialLimit::sum})
    for (const bool bonded : {true, false})
    {
      const auto force = [&](const double gap)
      {
        return respond_to_contact(face.at({1., 0.5, gap}, {0., 0., gap}, 0.), {1e6, 5e5, 0.4, 100., form},
                                  Vector3d::Zero(), 0., bonded)
            .force;
      };
      EXPECT_LT((force(1e-9) - force(-1e-9)).norm(), 2e-9 * 12e6); // at most (1 / 0.1 + 0.4) of the normal spring
    }
}

TEST(CoulombLaw, AdhesionHoldsWithoutFriction)
{
  const Body face{"face", 1};
  const ContactResponse response = respond_to_contact(face.at({1., 0., -1e-3}, {0., 0., -1e-3}, 0.),
                                                      {1e6, 5e5, 0., 100., TangentialLimit::sum}, Vector3d::Zero());
  EXPECT_NEAR(response.force[0], -100., 1e-9);
}
