// The fields that can be written, and how each follows from the data of particles and rigid points.
#pragma once

#include <functional>
#include <kedge/bodies/rigid_systems.h>
#include <kedge/particles/particle_set.h>
#include <string>
#include <vector>

namespace kedge
{
/// Pointers to the data of one particle; valid until the particles change.
struct ParticleView
{
  long long id;
  const double *position, *data; ///< location (dim entries, m) and properties
};

/// The particles of this rank in the mesh's window by layer, each list in the order of the numbers.
template <int dim>
std::vector<std::vector<ParticleView>> particles_by_layer(const BackgroundMesh<dim>& mesh,
                                                          const ParticleSet<dim>& particles, unsigned int n_layers);

struct ParticleField
{
  std::string name;
  unsigned int n_components;
  std::function<void(const ParticleView&, double* value)> evaluate; ///< writes n_components values
};

/// Description of a field for the manual.
struct FieldDescription
{
  std::string name, columns, unit, sentence;
};

/// Every field of material points that can be written, in the order of the tables: the fields of particles/fields.h and
/// those derived from them.
std::vector<FieldDescription> describe_particle_fields();

struct BodyField
{
  std::string name;
  unsigned int n_components;
  void (*evaluate)(const RigidPoint&, const Vector6& reaction, double* value);
};

/// The fields with these names (see output/parameters.h). Components are along x, y, z; in plane strain y is the
/// direction out of the plane. "law state" stands for the state variables of the layer's law; each becomes a field.
template <int dim>
std::vector<ParticleField> select_particle_fields(const std::vector<std::string>& names,
                                                  const std::vector<StateVariable>& of_law = {});
std::vector<BodyField> select_body_fields(const std::vector<std::string>& names);

/// Names of the components of a field: 3 are x y z, 6 are xx yy zz xy yz xz, 9 are 1 to 9; a scalar has none.
const std::vector<std::string>& component_names(unsigned int n_components);

/// "position_x", "stress_xx", "mass": the columns of a field in a table.
std::vector<std::string> column_names(const std::string& field, unsigned int n_components);

template <typename Field> unsigned int count_components(const std::vector<Field>& fields)
{
  unsigned int n = 0;
  for (const Field& field : fields)
    n += field.n_components;
  return n;
}

/// Velocity of a point that is given in the body frame, m/s.
inline Eigen::Vector3d velocity_at(const RigidPoint& point, const Eigen::Vector3d& X)
{
  return point.velocity.head<3>() + point.velocity.tail<3>().cross(point.pose.direction_to_world(X));
}

/// Reaction of the conditions on a rigid point; zero if none was computed (`reactions` is empty).
inline Vector6 reaction_on(const std::vector<Vector6>& reactions, std::size_t point)
{
  return point < reactions.size() ? reactions[point] : Vector6(Vector6::Zero());
}
} // namespace kedge
