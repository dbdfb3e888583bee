// The shape of the octree as plain numbers, from which the same mesh is built again.
#pragma once

#include <kedge/mesh/background_mesh.h>

namespace kedge
{
/// A leaf: its level and, for its lower corner, how many edges of its own size lie before it along each axis.
template <int dim> struct LeafPlace
{
  unsigned int level;
  std::array<std::int64_t, dim> index;
};

/// Owned leaves in the order in which the forest is spread over the ranks: put one after the other, those of rank 0, of
/// rank 1 and so on are in one order that does not depend on the number of ranks.
template <int dim>
std::vector<typename BackgroundMesh<dim>::Cell> cells_in_forest_order(const BackgroundMesh<dim>& mesh);

template <int dim>
LeafPlace<dim> place_of(const typename BackgroundMesh<dim>::Cell& cell, const BackgroundMesh<dim>& mesh);

/// Refines a mesh of base cells alone until it has these leaves (of all ranks, in any order). Call update() afterwards.
/// Collective.
template <int dim> void refine_to(BackgroundMesh<dim>& mesh, const std::vector<LeafPlace<dim>>& leaves);

/// Gives each rank as many leaves as `counts` says, in the order of the forest; they must be as many as there are, and
/// siblings stay together. Ranks without leaves keep what p4est leaves them. Call update() afterwards. Collective.
template <int dim> void repartition_to(BackgroundMesh<dim>& mesh, const std::vector<std::int64_t>& counts);
} // namespace kedge
