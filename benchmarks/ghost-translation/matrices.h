// Stiffness and mass with their stabilisation for a block of soil at rest, as dense matrices.
#pragma once

#include <Eigen/Dense>
#include <kedge/mesh/background_mesh.h>
#include <memory>

namespace kedge::translation
{
/// Cells of 1 m; where `octree`, those beyond x = 2 m are refined once.
template <int dim> std::unique_ptr<BackgroundMesh<dim>> make_mesh(bool octree);

enum class Kind
{
  stiffness,
  mass
};

/// Of all active nodes with factor 1: a factor's matrix is base + factor * ghost. Mass has one unknown per node.
struct Matrices
{
  Eigen::MatrixXd base, ghost;
};

/// A block of edge 2 m with E = 1 Pa, nu = 0, density 1 kg/m3, two particles per finest cell and axis, its lower corner
/// at (1 + offset) m along every axis.
template <int dim>
Matrices make_matrices(const BackgroundMesh<dim>& mesh, bool octree, bool gimp, Kind kind, double offset);

/// Largest over smallest eigenvalue, the `n_rigid` smallest left out; at most 1e16, where round-off takes over.
/// Unknowns that nothing reaches are left out too.
double condition_number(const Eigen::MatrixXd& matrix, unsigned int n_rigid);
} // namespace kedge::translation
