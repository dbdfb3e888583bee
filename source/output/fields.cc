#include <algorithm>
#include <kedge/base/world_axes.h>
#include <kedge/output/fields.h>
#include <stdexcept>

namespace kedge
{
namespace
{
double volume_ratio(const double* data)
{
  const double* F = data + field::deformation_gradient;
  return F[0] * (F[4] * F[8] - F[5] * F[7]) - F[1] * (F[3] * F[8] - F[5] * F[6]) + F[2] * (F[3] * F[7] - F[4] * F[6]);
}

/// Values of a kind of field, in world axes.
template <int dim> void copy_in_world_axes(const FieldKind kind, const double* stored, double* value)
{
  switch (kind)
  {
    case FieldKind::scalar:
      *value = *stored;
      break;
    case FieldKind::vector:
      for (unsigned int d = 0; d < 3; ++d)
        value[d] = stored[stored_axis<dim>[d]];
      break;
    case FieldKind::symmetric:
      for (unsigned int i = 0; i < 6; ++i)
        value[i] = stored[stored_entry<dim>[i]];
      break;
    case FieldKind::general:
      for (unsigned int i = 0; i < 3; ++i)
        for (unsigned int j = 0; j < 3; ++j)
          value[3 * i + j] = stored[3 * stored_axis<dim>[i] + stored_axis<dim>[j]];
      break;
    case FieldKind::law_state: // one scalar after the other
      break;
  }
}

template <int dim> void copy_position(const double* position, double* value)
{
  const Eigen::Vector3d x = to_world<dim>(position);
  std::copy_n(x.data(), 3, value);
}

/// A field derived from stored ones. In tables it stands behind the stored field `after`.
struct DerivedField
{
  const char *name, *after;
  FieldKind kind;
  const char *unit, *sentence;
  void (*evaluate_in_2d)(const ParticleView&, double* value);
  void (*evaluate_in_3d)(const ParticleView&, double* value);
};

template <int dim> void evaluate_position(const ParticleView& p, double* value)
{
  copy_position<dim>(p.position, value);
}

template <int dim> void evaluate_displacement(const ParticleView& p, double* value)
{
  double start[3];
  copy_in_world_axes<dim>(FieldKind::vector, p.data + field::initial_position, start);
  copy_position<dim>(p.position, value);
  for (unsigned int d = 0; d < 3; ++d)
    value[d] -= start[d];
}

template <int dim> void evaluate_stress(const ParticleView& p, double* value)
{
  copy_in_world_axes<dim>(FieldKind::symmetric, p.data + field::stress, value);
  const double factor = 1. / volume_ratio(p.data);
  for (unsigned int i = 0; i < 6; ++i)
    value[i] *= factor;
}

void evaluate_volume(const ParticleView& p, double* value)
{
  *value = p.data[field::initial_volume] * volume_ratio(p.data);
}

constexpr DerivedField derived_fields[] = {
    {"position", "initial position", FieldKind::vector, "m", "of the centre", evaluate_position<2>,
     evaluate_position<3>},
    {"displacement", "initial position", FieldKind::vector, "m", "of the centre", evaluate_displacement<2>,
     evaluate_displacement<3>},
    {"stress", "kirchhoff stress", FieldKind::symmetric, "Pa", "Cauchy stress, tension positive", evaluate_stress<2>,
     evaluate_stress<3>},
    {"volume", "strain", FieldKind::scalar, "m3", "in 2-D per metre", evaluate_volume, evaluate_volume}};

template <int dim> ParticleField make_field(const DerivedField& derived)
{
  return {derived.name, n_components(derived.kind), dim == 3 ? derived.evaluate_in_3d : derived.evaluate_in_2d};
}

template <int dim> ParticleField make_field(const FieldDeclaration& stored, const unsigned int offset)
{
  return {std::string(stored.name), n_components(stored.kind),
          [kind = stored.kind, offset](const ParticleView& p, double* value)
          { copy_in_world_axes<dim>(kind, p.data + offset, value); }};
}

/// Every field that can be written but the state variables, which differ from law to law.
template <int dim> std::vector<ParticleField> all_particle_fields()
{
  std::vector<ParticleField> fields;
  for_each_field(
      [&](const FieldDeclaration& stored, const unsigned int offset)
      {
        if (stored.is_written && stored.kind != FieldKind::law_state)
          fields.push_back(make_field<dim>(stored, offset));
        for (const DerivedField& derived : derived_fields)
          if (derived.after == stored.name)
            fields.push_back(make_field<dim>(derived));
      });
  return fields;
}

std::string text_of_columns(const FieldKind kind)
{
  if (kind == FieldKind::law_state)
    return "named by the law";
  std::string text;
  for (const std::string& component : component_names(n_components(kind)))
    text += (text.empty() ? "_" : " _") + component;
  return text;
}

void copy(const Eigen::Vector3d& vector, double* value) { std::copy_n(vector.data(), 3, value); }

const std::vector<BodyField>& all_body_fields()
{
  using P = const RigidPoint&;
  using R = const Vector6&;
  static const std::vector<BodyField> fields = {
      {"position", 3, [](P point, R, double* value) { copy(point.pose.position, value); }},
      {"velocity", 3, [](P point, R, double* value) { copy(point.velocity.head<3>(), value); }},
      {"acceleration", 3, [](P point, R, double* value) { copy(point.reported_acceleration.head<3>(), value); }},
      {"angular velocity", 3, [](P point, R, double* value) { copy(point.velocity.tail<3>(), value); }},
      {"angular acceleration", 3,
       [](P point, R, double* value) { copy(point.reported_acceleration.tail<3>(), value); }},
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
std::vector<std::vector<ParticleView>> particles_by_layer(const BackgroundMesh<dim>& mesh,
                                                          const ParticleSet<dim>& particles, unsigned int n_layers)
{
  std::vector<std::vector<ParticleView>> layers(n_layers);
  for (const auto& particle : particles.handler())
  {
    if (!mesh.in_window(particle.get_surrounding_cell()))
      continue;
    const double* data = particle.get_properties().data();
    layers.at(static_cast<unsigned int>(data[field::layer]))
        .push_back({static_cast<long long>(particle.get_id()), &particle.get_location()[0], data});
  }
  for (auto& layer : layers)
    std::sort(layer.begin(), layer.end(), [](const ParticleView& a, const ParticleView& b) { return a.id < b.id; });
  return layers;
}

std::vector<FieldDescription> describe_particle_fields()
{
  std::vector<FieldDescription> descriptions;
  for_each_field(
      [&](const FieldDeclaration& stored, unsigned int)
      {
        if (stored.is_written)
          descriptions.push_back({std::string(stored.name), text_of_columns(stored.kind), std::string(stored.unit),
                                  std::string(stored.sentence)});
        for (const DerivedField& derived : derived_fields)
          if (derived.after == stored.name)
            descriptions.push_back({derived.name, text_of_columns(derived.kind), derived.unit, derived.sentence});
      });
  return descriptions;
}

template <int dim>
std::vector<ParticleField> select_particle_fields(const std::vector<std::string>& names,
                                                  const std::vector<StateVariable>& of_law)
{
  const std::vector<ParticleField> all = all_particle_fields<dim>();
  std::vector<ParticleField> selected;
  for (const std::string& name : names)
    if (name == "law state")
      for (unsigned int k = 0; k < of_law.size(); ++k)
        selected.push_back({of_law[k].name, 1, [at = field::law_state + k](const ParticleView& p, double* value) {
                              *value = p.data[at];
                            }});
    else
      selected.push_back(select(all, {name})[0]);
  return selected;
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

template std::vector<std::vector<ParticleView>> particles_by_layer<2>(const BackgroundMesh<2>&, const ParticleSet<2>&,
                                                                      unsigned int);
template std::vector<std::vector<ParticleView>> particles_by_layer<3>(const BackgroundMesh<3>&, const ParticleSet<3>&,
                                                                      unsigned int);
template std::vector<ParticleField> select_particle_fields<2>(const std::vector<std::string>&,
                                                              const std::vector<StateVariable>&);
template std::vector<ParticleField> select_particle_fields<3>(const std::vector<std::string>&,
                                                              const std::vector<StateVariable>&);
} // namespace kedge
