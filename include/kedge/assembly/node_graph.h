// Which nodes couple, over all ranks, and the Tpetra maps and graph that follow from it.
#pragma once

#include <kedge/base/tpetra.h>
#include <kedge/basis/stencil.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// The numbering of unknowns that assembly needs. Nodes that this rank owns come first, then ghosts grouped by owner.
/// The numbers in `global` are contiguous over the ranks.
struct NodeNumbering
{
  MPI_Comm communicator = MPI_COMM_WORLD;
  unsigned int n_owned = 0;
  std::vector<long long> global;
  std::vector<unsigned int> ghost_begin; ///< per rank, plus the end
};

/// Lists of local node numbers in compressed rows. The nodes of a list all couple with each other.
struct NodeLists
{
  View<unsigned int*> begin, nodes;
};

/// Rows: owned nodes, then the ghosts of the stencils, whose contributions are sent to their owners. Columns: the same
/// nodes, then further ghosts that only other ranks' contributions reach. Each entry stands for a dim x dim block. The
/// value of row r, component i, column position k, component j lies at
/// dim^2 row_begin[r] + i dim length(r) + dim k + j. In this layout the owned rows are already a Tpetra matrix.
struct NodeGraph
{
  unsigned int dim = 3, n_owned = 0, n_rows = 0, n_columns = 0;
  MPI_Comm communicator = MPI_COMM_WORLD;
  View<std::size_t*> row_begin; ///< n_rows + 1
  View<unsigned int*> column;   ///< ascending within a row
  Teuchos::RCP<const TpetraMap> row_map, column_map;
  Teuchos::RCP<const TpetraGraph> matrix_graph; ///< of the owned rows

  /// Ghost rows to send: entries [send_begin[r], send_begin[r + 1]) of `column` belong to rank r.
  std::vector<std::size_t> send_begin;
  /// Destination of each block received, in rank order: begin of its row in `column`, and the length of the row and the
  /// position in it, both here and at the sender. The layout of the values needs these.
  struct Target
  {
    std::size_t row_begin, sender_offset;
    unsigned int length, position, sender_length, sender_position;
  };
  std::vector<Target> targets;
  std::vector<std::size_t> receive_count; ///< blocks per rank

  std::size_t n_values() const { return static_cast<std::size_t>(dim) * dim * column.extent(0); }
};

/// Map of the dofs of the first `n` nodes, by the nodes' global numbers. The dofs of a node follow the order of the
/// axes. Collective.
Teuchos::RCP<const TpetraMap> make_dof_map(unsigned int dim, const std::vector<long long>& node, std::size_t n);

/// Couples the nodes of this rank's lists. Without maps, the matrix graph and what rows are sent by.
NodeGraph build_local_graph(unsigned int dim, const NodeNumbering& numbering, const std::vector<NodeLists>& couplings);

/// Couples the nodes of all ranks' lists. Collective.
NodeGraph build_node_graph(unsigned int dim, const NodeNumbering& numbering, const std::vector<NodeLists>& couplings);

/// Adds the ghost rows of `values` (laid out as the graph says) to the rows of their owners. Collective.
void send_ghost_rows(const NodeGraph& graph, const View<double*>& values);
} // namespace kedge
