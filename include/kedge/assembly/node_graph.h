// Which nodes couple, over all ranks, and the Tpetra maps and graph that follow from it.
#pragma once

#include <kedge/base/tpetra.h>
#include <kedge/basis/stencil.h>
#include <mpi.h>
#include <vector>

namespace kedge
{
/// What assembly must know of the numbering of unknowns: nodes that this rank owns come first, then ghosts grouped by
/// owner; `global` numbers are contiguous over the ranks.
struct NodeNumbering
{
  MPI_Comm communicator = MPI_COMM_WORLD;
  unsigned int n_owned = 0;
  std::vector<long long> global;
  std::vector<unsigned int> ghost_begin; ///< per rank, plus the end
};

/// Node lists whose members all couple with each other, in compressed rows of local node numbers.
struct NodeLists
{
  View<unsigned int*> begin, nodes;
};

/// Rows: owned nodes, then the ghosts of the stencils, whose contributions are sent to their owners. Columns: the same
/// nodes, then further ghosts that only other ranks' contributions reach. Each entry stands for a dim x dim block; the
/// values of row r, component i, column position k, component j lie at
/// dim^2 row_begin[r] + i dim length(r) + dim k + j, so the owned rows form a Tpetra matrix as they are.
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
  /// Where the blocks received from all ranks (in rank order) go: entry of `column`, and the row's length and position
  /// here and at the sender, which the layout of the values asks for.
  struct Target
  {
    std::size_t row_begin, sender_offset;
    unsigned int length, position, sender_length, sender_position;
  };
  std::vector<Target> targets;
  std::vector<std::size_t> receive_count; ///< blocks per rank

  std::size_t n_values() const { return static_cast<std::size_t>(dim) * dim * column.extent(0); }
};

/// One dof per node and component of the first `n` nodes, by their global numbers; the order of components within a
/// node is the axes'. Collective.
Teuchos::RCP<const TpetraMap> make_dof_map(unsigned int dim, const std::vector<long long>& node, std::size_t n);

/// Collective.
NodeGraph build_node_graph(unsigned int dim, const NodeNumbering& numbering, const std::vector<NodeLists>& couplings);

/// Adds the ghost rows of `values` (laid out as the graph says) to the rows of their owners. Collective.
void send_ghost_rows(const NodeGraph& graph, const View<double*>& values);
} // namespace kedge
