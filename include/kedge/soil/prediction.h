// The guess from which Newton's method starts a step.
#pragma once

#include <kedge/mesh/leaf_table.h>
#include <mpi.h>
#include <optional>

namespace kedge
{
/// Nodal increments of a requested step (m, dim per node of the leaf table) as the last step had them. Nothing: rest,
/// on all ranks alike. A rank that knows no node has none of them where others have some.
using Prediction = std::optional<std::vector<double>>;

/// The prediction on a new mesh, from the shape functions of the old one, whichever rank has it; zero off the grid.
/// Collective.
template <int dim>
Prediction transfer_prediction(const Prediction& prediction, const LeafTable<dim>& from, const LeafTable<dim>& to,
                               MPI_Comm communicator);
} // namespace kedge
