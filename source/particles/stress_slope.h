// How the stress changes from point to point within a cell, for the children of the cell's particles.
#pragma once

#include <Eigen/Dense>
#include <array>
#include <kedge/materials/material.h>
#include <kedge/particles/fields.h>

namespace kedge
{
/// Gradient of the Kirchhoff stress, Pa/m: a column per axis.
template <int dim> using StressSlope = Eigen::Matrix<double, 6, dim>;

/// The linear field through the stresses of some particles, by least squares weighted by the initial volume.
template <int dim> class StressFit
{
public:
  void add(const std::array<double, dim>& position, const double* data);

  /// None along axes on which the particles lie closer together than cells of this edge (m) say.
  StressSlope<dim> slope(double cell_size) const;

private:
  using Vector = Eigen::Matrix<double, dim, 1>;

  double volume = 0.;
  Vector first = Vector::Zero(), origin = Vector::Zero();
  Eigen::Matrix<double, dim, dim> second = Eigen::Matrix<double, dim, dim>::Zero();
  SymmetricTensor stress = SymmetricTensor::Zero();
  StressSlope<dim> moment = StressSlope<dim>::Zero();
};

/// Adds to a particle's stress what the slope makes of an offset (m), and to its elastic strain what belongs to it.
template <int dim>
void add_slope(const StressSlope<dim>& slope, const Eigen::Vector3d& offset, const Material& material, double* data);

/// Share of a slope, 0 to 1, that a particle's children can have: all of it where the law bears what they would have at
/// these distances (m) along the axes, none where the law would take half of the differences away. Continuous, so that
/// soil in flow, which lies on its yield surface, does not choose by round-off.
template <int dim>
double bearable_share(const StressSlope<dim>& slope, const Eigen::Vector3d& distance, const Material& material,
                      double cell_size, const double* data);
} // namespace kedge
