#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <kedge/solvers/coarse_nodes.h>
#include <numeric>

namespace kedge
{
namespace
{
/// Entries of modes below this belong to constrained unknowns.
constexpr double no_mode = 1e-6;
/// Of the length of a mode: what must be left of it beside the modes before it.
constexpr double least_share = 1e-6;
/// Instead of zero where MueLu asks for a mode.
constexpr double almost_zero = 1e-10;

std::vector<unsigned char> nodes_with_modes(const CoarseNodes& at, const TpetraMultiVector& modes)
{
  const auto view = modes.getLocalViewHost(Tpetra::Access::ReadOnly);
  std::vector<unsigned char> taken(view.extent(0) / at.size, 0);
  for (std::size_t a = 0; a < view.extent(1); ++a)
    for (std::size_t dof = 0; dof < view.extent(0); ++dof)
      if (std::abs(view(dof, a)) > no_mode)
        taken[dof / at.size] = 1;
  return taken;
}

void list_nodes(CoarseNodes& at)
{
  const std::vector<int>& of_node = at.aggregates.of_node;
  at.node_begin.assign(at.aggregates.n + 1, 0);
  for (const int aggregate : of_node)
    if (aggregate >= 0)
      ++at.node_begin[aggregate + 1];
  std::partial_sum(at.node_begin.begin(), at.node_begin.end(), at.node_begin.begin());
  std::vector<int> next(at.node_begin);
  at.nodes.resize(at.node_begin.back());
  for (std::size_t v = 0; v < of_node.size(); ++v)
    if (of_node[v] >= 0)
      at.nodes[next[of_node[v]]++] = static_cast<int>(v);
}

/// Makes the modes of an aggregate orthonormal (Gram-Schmidt, twice). Returns what they are in terms of the new ones;
/// the diagonal is zero where a mode depends on those before it or is zero, and so is its column.
Eigen::MatrixXd orthonormalise(Eigen::MatrixXd& columns)
{
  const Eigen::Index n = columns.cols();
  Eigen::MatrixXd terms = Eigen::MatrixXd::Zero(n, n);
  for (Eigen::Index a = 0; a < n; ++a)
  {
    const double length = columns.col(a).norm();
    for (int pass = 0; pass < 2; ++pass)
      for (Eigen::Index b = 0; b < a; ++b)
      {
        const double share = columns.col(b).dot(columns.col(a));
        terms(b, a) += share;
        columns.col(a) -= share * columns.col(b);
      }
    const double rest = columns.col(a).norm();
    if (rest > least_share * length)
    {
      terms(a, a) = rest;
      columns.col(a) /= rest;
    }
    else
      columns.col(a).setZero();
  }
  return terms;
}

/// Numbers the aggregates that the columns belong to. A column of vectors carries global numbers: doubles hold them.
void number_columns(CoarseNodes& at, const TpetraMatrix& matrix)
{
  const auto number = Teuchos::rcp(new TpetraMultiVector(matrix.getRowMap(), 1));
  {
    const auto view = number->getLocalViewHost(Tpetra::Access::OverwriteAll);
    for (std::size_t dof = 0; dof < view.extent(0); ++dof)
    {
      const int aggregate = at.aggregates.of_node[dof / at.size];
      view(dof, 0) = aggregate < 0 ? -1. : static_cast<double>(at.first() + aggregate);
    }
  }
  const auto all = with_ghosts(matrix, number);
  const auto view = all->getLocalViewHost(Tpetra::Access::ReadOnly);
  const std::size_t n_columns = view.extent(0) / at.size, n_owned = at.aggregates.of_node.size();
  const auto global = [&](const std::size_t v) { return static_cast<GlobalOrdinal>(view(at.size * v, 0)); };
  for (std::size_t v = n_owned; v < n_columns; ++v)
    if (global(v) >= 0)
      at.ghosts.push_back(global(v));
  std::sort(at.ghosts.begin(), at.ghosts.end());
  at.ghosts.erase(std::unique(at.ghosts.begin(), at.ghosts.end()), at.ghosts.end());
  at.aggregate_of_column = at.aggregates.of_node;
  for (std::size_t v = n_owned; v < n_columns; ++v)
    at.aggregate_of_column.push_back(
        global(v) < 0
            ? -1
            : at.aggregates.n + static_cast<int>(std::lower_bound(at.ghosts.begin(), at.ghosts.end(), global(v)) -
                                                 at.ghosts.begin()));
}
} // namespace

CoarseNodes make_coarse_nodes(const TpetraMatrix& matrix, const NodeBlocks& blocks, const TpetraMultiVector& modes)
{
  CoarseNodes at{blocks.block_size,
                 static_cast<unsigned int>(modes.getNumVectors()),
                 download(blocks.row_begin),
                 download(blocks.column),
                 {},
                 {},
                 {},
                 {},
                 {},
                 {}};
  at.aggregates = aggregate(at.row_begin, at.column, nodes_with_modes(at, modes));
  list_nodes(at);
  at.map = Teuchos::rcp(new TpetraMap(Teuchos::OrdinalTraits<Tpetra::global_size_t>::invalid(),
                                      std::size_t(at.modes) * at.aggregates.n, 0, matrix.getComm()));
  number_columns(at, matrix);
  return at;
}

void make_prolongator(const CoarseNodes& at, const TpetraMultiVector& modes, TpetraMultiVector& prolongator,
                      TpetraMultiVector& coarse_modes)
{
  const auto from = modes.getLocalViewHost(Tpetra::Access::ReadOnly);
  const auto to = prolongator.getLocalViewHost(Tpetra::Access::OverwriteAll);
  const auto coarse = coarse_modes.getLocalViewHost(Tpetra::Access::OverwriteAll);
  Kokkos::deep_copy(to, 0.);
  const unsigned int size = at.size, n_modes = at.modes;
  for (int aggregate = 0; aggregate < at.aggregates.n; ++aggregate)
  {
    const int begin = at.node_begin[aggregate], n = at.node_begin[aggregate + 1] - begin;
    Eigen::MatrixXd columns(size * n, n_modes);
    const auto visit = [&](const auto& work)
    {
      for (int v = 0; v < n; ++v)
        for (unsigned int i = 0; i < size; ++i)
          for (unsigned int a = 0; a < n_modes; ++a)
            work(columns(size * v + i, a), size * at.nodes[begin + v] + i, a);
    };
    visit([&](double& entry, const unsigned int dof, const unsigned int a)
          { entry = std::abs(from(dof, a)) > no_mode ? from(dof, a) : 0.; });
    const Eigen::MatrixXd terms = orthonormalise(columns);
    visit([&](const double entry, const unsigned int dof, const unsigned int a) { to(dof, a) = entry; });
    for (unsigned int a = 0; a < n_modes; ++a)
      for (unsigned int b = 0; b < n_modes; ++b)
        coarse(n_modes * aggregate + a, b) = a == b && terms(a, a) == 0. ? almost_zero : terms(a, b);
  }
}

Teuchos::RCP<const TpetraMultiVector> with_ghosts(const TpetraMatrix& matrix,
                                                  const Teuchos::RCP<const TpetraMultiVector>& owned)
{
  const auto importer = matrix.getGraph()->getImporter();
  if (importer.is_null())
    return owned;
  const auto all = Teuchos::rcp(new TpetraMultiVector(matrix.getColMap(), owned->getNumVectors()));
  all->doImport(*owned, *importer, Tpetra::INSERT);
  return all;
}
} // namespace kedge
