// The shape of the octree as plain numbers, for building the same mesh again.
#pragma once

#include <kedge/mesh/background_mesh.h>

namespace kedge
{
/// A leaf: its level below the base cells and, along each axis, the number of edges of its own size before its lower
/// corner.
template <int dim> struct LeafPlace
{
  unsigned int level;
  std::array<std::int64_t, dim> index;
};

/// Owned leaves in the order in which the forest is distributed over the ranks. The leaves of rank 0, then of rank 1
/// and so on form one sequence, which does not depend on the number of ranks.
template <int dim>
std::vector<typename BackgroundMesh<dim>::Cell> cells_in_forest_order(const BackgroundMesh<dim>& mesh);

template <int dim>
LeafPlace<dim> place_of(const typename BackgroundMesh<dim>::Cell& cell, const BackgroundMesh<dim>& mesh);

/// Refines a mesh that has base cells only until it has these leaves. Each rank gives some of them, whosever they are;
/// none needs to know all. Spreads the cells over the ranks after each level. Collective.
template <int dim> void refine_to(BackgroundMesh<dim>& mesh, const std::vector<LeafPlace<dim>>& leaves);

/// Gives rank r the next counts[r] leaves in the order of the forest. The counts must add up to all leaves and must
/// keep siblings together. A rank with a count of 0 gets what p4est leaves it. Call update() afterwards. Collective.
template <int dim> void repartition_to(BackgroundMesh<dim>& mesh, const std::vector<std::int64_t>& counts);
} // namespace kedge
