// What the input gives as functions of the place of a material point: body force and initial velocity.
#pragma once

#include <kedge/parameters/expression.h>
#include <kedge/particles/particle_set.h>

namespace kedge
{
/// X, Y, Z: the initial position of a material point, m; in 2-D X, Z.
std::vector<std::string> initial_variables(unsigned int dim);
/// In addition x, y, z: its present position, m; and t: time since the start of the stage, s, in static stages the load
/// fraction.
std::vector<std::string> present_variables(unsigned int dim);

/// An acceleration (m/s2) that acts on soil beside gravity. It acts on no body.
template <int dim> class BodyForce
{
public:
  explicit BodyForce(const ExpressionText& text);

  bool depends_on_time() const { return expression.uses("t"); }
  /// Its value at every material point of this rank, at the present position. Throws InputError on all ranks where it
  /// is not finite. Collective.
  View<double* [3]> evaluate(const ParticleSet<dim>& particles, double time, MPI_Comm communicator) const;

private:
  std::string path;
  Expression expression;
};

/// Gives all material points their velocity (m/s) at the start of the run. Throws InputError on all ranks where it is
/// not finite. Collective.
template <int dim>
void set_initial_velocity(ParticleSet<dim>& particles, const ExpressionText& text, MPI_Comm communicator);
} // namespace kedge
