// The guess from which Newton's method starts a step.
#pragma once

#include <kedge/mesh/leaf_table.h>
#include <mpi.h>

namespace kedge
{
/// Nodal increments of a requested step (m, dim per node of the leaf table) as the last step had them. Empty: rest.
using Prediction = std::vector<double>;

/// The prediction on a new mesh, from the shape functions of the old one, whichever rank has it; zero off the grid.
/// Collective.
template <int dim>
Prediction transfer_prediction(const Prediction& prediction, const LeafTable<dim>& from, const LeafTable<dim>& to,
                               MPI_Comm communicator);
} // namespace kedge
