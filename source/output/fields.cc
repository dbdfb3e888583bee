#include <algorithm>
#include <kedge/output/fields.h>
#include <stdexcept>

namespace kedge
{
namespace
{
/// Which stored axis is the world's x, y, z: plane strain keeps x, z and then y.
template <int dim> constexpr std::array<unsigned int, 3> stored_axis = {{0, dim == 3 ? 1 : 2, dim == 3 ? 2 : 1}};

/// Which stored entry of a symmetric tensor is the world's xx, yy, zz, xy, yz, xz.
template <int dim>
constexpr std::array<unsigned int, 6> stored_entry = {
    {0, dim == 3 ? 1 : 2, dim == 3 ? 2 : 1, dim == 3 ? 3 : 5, 4, dim == 3 ? 5 : 3}};

template <int dim> void copy_vector(const double* stored, double* value)
{
  for (unsigned int d = 0; d < 3; ++d)
    value[d] = stored[stored_axis<dim>[d]];
}

template <int dim> void copy_position(const double* position, double* value)
{
  value[0] = position[0];
  value[1] = dim == 3 ? position[1] : 0.;
  value[2] = position[dim - 1];
}

template <int dim> void copy_symmetric(const double* stored, double factor, double* value)
{
  for (unsigned int i = 0; i < 6; ++i)
    value[i] = factor * stored[stored_entry<dim>[i]];
}

double volume_ratio(const double* data)
{
  const double* F = data + field::deformation_gradient;
  return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
}

template <field::Offset offset> void evaluate_scalar(const ParticleView& p, double* value) { *value = p.data[offset]; }

template <int dim, field::Offset offset> void evaluate_vector(const ParticleView& p, double* value)
{
  copy_vector<dim>(p.data + offset, value);
}

template <int dim> void evaluate_position(const ParticleView& p, double* value)
{
  copy_position<dim>(p.position, value);
}

template <int dim> void evaluate_displacement(const ParticleView& p, double* value)
{
  double start[3];
  copy_vector<dim>(p.data + field::initial_position, start);
  copy_position<dim>(p.position, value);
  for (unsigned int d = 0; d < 3; ++d)
    value[d] -= start[d];
}

template <int dim> void evaluate_deformation_gradient(const ParticleView& p, double* value)
{
  for (unsigned int i = 0; i < 3; ++i)
    for (unsigned int j = 0; j < 3; ++j)
      value[3 * i + j] = p.data[field::deformation_gradient + 3 * stored_axis<dim>[i] + stored_axis<dim>[j]];
}

template <int dim> void evaluate_stress(const ParticleView& p, double* value)
{
  copy_symmetric<dim>(p.data + field::stress, 1. / volume_ratio(p.data), value);
}

template <int dim> void evaluate_strain(const ParticleView& p, double* value)
{
  copy_symmetric<dim>(p.data + field::elastic_strain, 1., value);
}

void evaluate_volume(const ParticleView& p, double* value)
{
  *value = p.data[field::initial_volume] * volume_ratio(p.data);
}

template <int dim> const std::vector<ParticleField>& all_particle_fields()
{
  static const std::vector<ParticleField> fields = {
      {"initial position", 3, evaluate_vector<dim, field::initial_position>},
      {"position", 3, evaluate_position<dim>},
      {"displacement", 3, evaluate_displacement<dim>},
      {"velocity", 3, evaluate_vector<dim, field::velocity>},
      {"acceleration", 3, evaluate_vector<dim, field::acceleration>},
      {"lp", 3, evaluate_vector<dim, field::half_width>},
      {"deformation gradient", 9, evaluate_deformation_gradient<dim>},
      {"stress", 6, evaluate_stress<dim>},
      {"strain", 6, evaluate_strain<dim>},
      {"volume", 1, evaluate_volume},
      {"initial volume", 1, evaluate_scalar<field::initial_volume>},
      {"plastic strain", 1, evaluate_scalar<field::plastic_strain>},
      {"young modulus", 1, evaluate_scalar<field::young>},
      {"contact gap", 1, evaluate_scalar<field::contact_gap>}};
  return fields;
}

void copy(const Eigen::Vector3d& vector, double* value) { std::copy_n(vector.data(), 3, value); }

const std::vector<BodyField>& all_body_fields()
{
  using P = const RigidPoint&;
  using R = const Vector6&;
  static const std::vector<BodyField> fields = {
      {"position", 3, [](P point, R, double* value) { copy(point.pose.position, value); }},
      {"velocity", 3, [](P point, R, double* value) { copy(point.velocity.head<3>(), value); }},
      {"acceleration", 3, [](P point, R, double* value) { copy(point.acceleration.head<3>(), value); }},
      {"angular velocity", 3, [](P point, R, double* value) { copy(point.velocity.tail<3>(), value); }},
      {"angular acceleration", 3, [](P point, R, double* value) { copy(point.acceleration.tail<3>(), value); }},
      {"mass", 1, [](P point, R, double* value) { *value = point.mass; }},
      {"reaction force", 3, [](P, R reaction, double* value) { copy(reaction.head<3>(), value); }},
      {"reaction moment", 3, [](P, R reaction, double* value) { copy(reaction.tail<3>(), value); }},
      {"rotation", 3, [](P point, R, double* value) { copy(vector_from_rotation(point.pose.rotation), value); }}};
  return fields;
}

template <typename Field>
std::vector<Field> select(const std::vector<Field>& all, const std::vector<std::string>& names)
{
  std::vector<Field> selected;
  for (const std::string& name : names)
  {
    const auto found = std::find_if(all.begin(), all.end(), [&](const Field& field) { return field.name == name; });
    if (found == all.end())
      throw std::logic_error("no field is called \"" + name + "\"");
    selected.push_back(*found);
  }
  return selected;
}
} // namespace

template <int dim>
std::vector<std::vector<ParticleView>> particles_by_layer(const ParticleSet<dim>& particles, unsigned int n_layers)
{
  std::vector<std::vector<ParticleView>> layers(n_layers);
  for (const auto& particle : particles.handler())
  {
    const double* data = particle.get_properties().data();
    layers.at(static_cast<unsigned int>(data[field::layer]))
        .push_back({static_cast<long long>(particle.get_id()), &particle.get_location()[0], data});
  }
  for (auto& layer : layers)
    std::sort(layer.begin(), layer.end(), [](const ParticleView& a, const ParticleView& b) { return a.id < b.id; });
  return layers;
}

template <int dim> std::vector<ParticleField> select_particle_fields(const std::vector<std::string>& names)
{
  return select(all_particle_fields<dim>(), names);
}

std::vector<BodyField> select_body_fields(const std::vector<std::string>& names)
{
  return select(all_body_fields(), names);
}

const std::vector<std::string>& component_names(unsigned int n_components)
{
  static const std::vector<std::string> none, vector = {"x", "y", "z"},
                                              symmetric = {"xx", "yy", "zz", "xy", "yz", "xz"},
                                              general = {"1", "2", "3", "4", "5", "6", "7", "8", "9"};
  switch (n_components)
  {
    case 3:
      return vector;
    case 6:
      return symmetric;
    case 9:
      return general;
    default:
      return none;
  }
}

std::vector<std::string> column_names(const std::string& field, unsigned int n_components)
{
  if (n_components == 1)
    return {field};
  std::vector<std::string> columns;
  for (const std::string& component : component_names(n_components))
    columns.push_back(field + "_" + component);
  return columns;
}

template std::vector<std::vector<ParticleView>> particles_by_layer<2>(const ParticleSet<2>&, unsigned int);
template std::vector<std::vector<ParticleView>> particles_by_layer<3>(const ParticleSet<3>&, unsigned int);
template std::vector<ParticleField> select_particle_fields<2>(const std::vector<std::string>&);
template std::vector<ParticleField> select_particle_fields<3>(const std::vector<std::string>&);
} // namespace kedge
