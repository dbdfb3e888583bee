#include <gtest/gtest.h>
#include <kedge/output/fields.h>
#include <kedge/output/parameters.h>

namespace kedge
{
namespace
{
/// Data of one particle, every entry different: data[k] = k, F with determinant 2.
struct Particle
{
  Particle()
  {
    for (unsigned int i = 0; i < field::count; ++i)
      data[i] = i;
    const double F[9] = {1., 0.5, 0.25, 0., 2., 0.125, 0., 0., 1.};
    std::copy_n(F, 9, data + field::deformation_gradient);
  }

  template <int dim> std::vector<double> evaluate(const std::string& name) const
  {
    const ParticleField field = select_particle_fields<dim>({name})[0];
    std::vector<double> value(field.n_components);
    field.evaluate({1, position, data}, value.data());
    return value;
  }

  double position[3] = {100., 200., 300.}, data[field::count];
};

using Values = std::vector<double>;

/// What lies at these places behind an offset, times a factor.
Values stored(const unsigned int offset, const std::vector<unsigned int>& places, const double factor = 1.)
{
  Values values;
  for (const unsigned int place : places)
    values.push_back(factor * (offset + place));
  return values;
}

/// Stored as xx, zz, yy, xz, zy, xy.
const std::vector<unsigned int> symmetric_in_plane_strain = {0, 2, 1, 5, 4, 3};

TEST(ParticleFields, EveryNameOfTheInputIsKnown)
{
  const std::vector<StateVariable> two = {{"strength", "Pa", ""}, {"strain", "-", ""}};
  for (const std::string& name : particle_field_names())
  {
    const std::size_t expected = name == "law state" ? 2 : 1;
    EXPECT_EQ(select_particle_fields<2>({name}, two).size(), expected) << name;
    EXPECT_EQ(select_particle_fields<3>({name}, two).size(), expected) << name;
  }
}

TEST(ParticleFields, VectorsInSpace)
{
  const Particle particle;
  const double start = field::initial_position;
  EXPECT_EQ(particle.evaluate<3>("initial position"), stored(field::initial_position, {0, 1, 2}));
  EXPECT_EQ(particle.evaluate<3>("position"), Values({100, 200, 300}));
  EXPECT_EQ(particle.evaluate<3>("displacement"), Values({100 - start, 199 - start, 298 - start}));
  EXPECT_EQ(particle.evaluate<3>("lp"), stored(field::half_width, {0, 1, 2}));
  EXPECT_EQ(particle.evaluate<3>("velocity"), stored(field::velocity, {0, 1, 2}));
  EXPECT_EQ(particle.evaluate<3>("acceleration"), stored(field::acceleration, {0, 1, 2}));
}

TEST(ParticleFields, VectorsInPlaneStrainHaveYOutOfThePlane)
{
  const Particle particle;
  EXPECT_EQ(particle.evaluate<2>("initial position"), stored(field::initial_position, {0, 2, 1}));
  EXPECT_EQ(particle.evaluate<2>("position"), Values({100, 0, 200}));
  EXPECT_EQ(particle.evaluate<2>("lp"), stored(field::half_width, {0, 2, 1}));
  EXPECT_EQ(particle.evaluate<2>("velocity"), stored(field::velocity, {0, 2, 1}));
}

TEST(ParticleFields, StressIsKirchhoffOverVolumeRatio)
{
  EXPECT_EQ(Particle().evaluate<3>("stress"), stored(field::stress, {0, 1, 2, 3, 4, 5}, 0.5));
}

TEST(ParticleFields, SymmetricTensorsInPlaneStrain)
{
  EXPECT_EQ(Particle().evaluate<3>("strain"), stored(field::elastic_strain, {0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(Particle().evaluate<2>("strain"), stored(field::elastic_strain, symmetric_in_plane_strain));
  EXPECT_EQ(Particle().evaluate<2>("stress"), stored(field::stress, symmetric_in_plane_strain, 0.5));
}

TEST(ParticleFields, DeformationGradient)
{
  EXPECT_EQ(Particle().evaluate<3>("deformation gradient"), Values({1, 0.5, 0.25, 0, 2, 0.125, 0, 0, 1}));
  EXPECT_EQ(Particle().evaluate<2>("deformation gradient"), Values({1, 0.25, 0.5, 0, 1, 0, 0, 0.125, 2}));
}

TEST(ParticleFields, Scalars)
{
  const Particle particle;
  EXPECT_EQ(particle.evaluate<3>("initial volume"), stored(field::initial_volume, {0}));
  EXPECT_EQ(particle.evaluate<3>("volume"), stored(field::initial_volume, {0}, 2.));
  EXPECT_EQ(particle.evaluate<3>("young modulus"), stored(field::young, {0}));
  EXPECT_EQ(particle.evaluate<3>("plastic strain"), stored(field::plastic_strain, {0}));
  EXPECT_EQ(particle.evaluate<3>("contact gap"), stored(field::contact_gap, {0}));
}

TEST(ParticleFields, StateVariablesHaveTheNamesOfTheLaw)
{
  const Particle particle;
  const auto fields = select_particle_fields<2>({"law state"}, {{"strength", "Pa", ""}, {"strain", "-", ""}});
  ASSERT_EQ(fields.size(), 2u);
  for (unsigned int k = 0; k < 2; ++k)
  {
    double value = 0.;
    fields[k].evaluate({1, particle.position, particle.data}, &value);
    EXPECT_EQ(value, field::law_state + k);
  }
  EXPECT_EQ(fields[1].name, "strain");
}

TEST(BodyFields, EveryNameOfTheInputReadsItsMember)
{
  RigidPoint point;
  point.pose.position = {1, 2, 3};
  point.pose.rotation = rotation_from_vector({0.1, 0.2, 0.3});
  point.velocity << 4, 5, 6, 7, 8, 9;
  point.reported_acceleration << 10, 11, 12, 13, 14, 15;
  point.mass = 16;
  Vector6 reaction;
  reaction << 17, 18, 19, 20, 21, 22;
  const std::map<std::string, Values> expected = {{"position", {1, 2, 3}},
                                                  {"velocity", {4, 5, 6}},
                                                  {"angular velocity", {7, 8, 9}},
                                                  {"acceleration", {10, 11, 12}},
                                                  {"mass", {16}},
                                                  {"angular acceleration", {13, 14, 15}},
                                                  {"rotation", {0.1, 0.2, 0.3}},
                                                  {"reaction force", {17, 18, 19}},
                                                  {"reaction moment", {20, 21, 22}}};
  ASSERT_EQ(expected.size(), body_field_names().size());
  for (const BodyField& field : select_body_fields(body_field_names()))
  {
    Values value(field.n_components);
    field.evaluate(point, reaction, value.data());
    ASSERT_EQ(value.size(), expected.at(field.name).size()) << field.name;
    for (std::size_t i = 0; i < value.size(); ++i)
      EXPECT_NEAR(value[i], expected.at(field.name)[i], 1e-14) << field.name;
  }
}

TEST(Fields, ColumnNames)
{
  using Names = std::vector<std::string>;
  EXPECT_EQ(column_names("volume", 1), Names({"volume"}));
  EXPECT_EQ(column_names("lp", 3), Names({"lp_x", "lp_y", "lp_z"}));
  EXPECT_EQ(column_names("stress", 6),
            Names({"stress_xx", "stress_yy", "stress_zz", "stress_xy", "stress_yz", "stress_xz"}));
  EXPECT_EQ(column_names("F", 9), Names({"F_1", "F_2", "F_3", "F_4", "F_5", "F_6", "F_7", "F_8", "F_9"}));
}
} // namespace
} // namespace kedge
