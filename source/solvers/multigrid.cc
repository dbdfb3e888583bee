#include <MueLu_CreateTpetraPreconditioner.hpp>
#include <cmath>
#include <kedge/base/failure.h>
#include <kedge/solvers/block_gauss_seidel.h>
#include <kedge/solvers/coarsening.h>
#include <kedge/solvers/multigrid.h>

namespace kedge
{
namespace
{
using Hierarchy = MueLu::TpetraOperator<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;

/// Of the finest level's smoother after the coarse correction. On a plate pulled through sand two take a quarter fewer
/// iterations than one, each dearer by a seventh.
constexpr unsigned int sweeps = 2;
/// On all levels, before and after the coarse correction, where those do not do.
constexpr int strong_sweeps = 4;
/// What one rank takes over from others on levels with few rows.
struct Gathering
{
  int few_rows; ///< of a level that one rank factorises
  int least;    ///< rows per rank below which fewer ranks take a level
  int target;   ///< rows of each of these
};

/// Each aggregate has a row per mode and a rank at least one aggregate, so among many ranks one that takes over 100
/// rows gets messages from about 17 others; one that takes all rows of a level gets them from all.
Gathering gathering(const int n_ranks)
{
  constexpr int few_ranks = 16;
  return n_ranks <= few_ranks ? Gathering{1000, 1000, 2000} : Gathering{100, 50, 100};
}

/// Whether MueLu can bring a level together on one rank. What scripts/build-trilinos builds cannot.
#ifdef HAVE_MUELU_ZOLTAN2
constexpr bool gathers_levels = true;
#else
constexpr bool gathers_levels = false;
#endif

/// How the coarsest level is solved.
enum class Coarsest
{
  factorised, ///< on one rank
  smoothed    ///< where it lies
};

/// Of MueLu's levels. Where threads work at once, the form by two stages takes as many iterations as
/// that by colours and is set up in a third of the time (plate pulled through sand).
const char* relaxation()
{
  return sweep_order() == SweepOrder::by_number ? "Symmetric Gauss-Seidel" : "Two-stage Symmetric Gauss-Seidel";
}

/// Of the levels below the finest one.
Teuchos::ParameterList hierarchy_parameters(const unsigned int block_size, const bool strong, const int n_ranks,
                                            const Coarsest coarsest)
{
  const Gathering gathers = gathering(n_ranks);
  Teuchos::ParameterList list;
  list.set("verbosity", "none");
  list.set("number of equations", static_cast<int>(block_size));
  // Measured on yielding sand and on an elastic cube of 100 000 dofs: smoothing the prolongators saves hardly an
  // iteration but makes set-up 2.5 times dearer.
  list.set("multigrid algorithm", strong ? "sa" : "unsmoothed");
  list.set("smoother: pre or post", strong ? "both" : "post");
  list.set("aggregation: type", "uncoupled");
  list.set("aggregation: drop tol", 0.0);
  list.set("coarse: max size", coarsest == Coarsest::smoothed ? 300 : gathers.few_rows);
  if (n_ranks > 1 && coarsest == Coarsest::factorised)
  {
    // Neighbouring ranks have neighbouring parts, so blocks of the rows' numbers are parts of the soil. MueLu's first
    // level stays as it is, for apply() takes its vectors.
    list.set("repartition: enable", true);
    list.set("repartition: partitioner", "zoltan2");
    list.sublist("repartition: params").set("algorithm", "block");
    list.set("repartition: start level", 1);
    list.set("repartition: min rows per proc", gathers.least);
    list.set("repartition: target rows per proc", gathers.target);
    list.set("repartition: rebalance P and R", false); // as renew() needs it
  }
  if (coarsest == Coarsest::smoothed)
  {
    // KLU2 of Trilinos 13 gives wrong results for matrices on several ranks, also for symmetric ones.
    list.set("coarse: type", "RELAXATION");
    Teuchos::ParameterList& coarse = list.sublist("coarse: params");
    coarse.set("relaxation: type", relaxation());
    coarse.set("relaxation: sweeps", 8);
  }
  else
    list.set("coarse: type", "KLU2");
  // A node outside all aggregates has fewer unknowns than modes, which leaves empty rows in the coarse matrix.
  list.set("rap: fix zero diagonals", true);
  list.set("max levels", 5);
  list.set("rap: triple product", false); // three times as slow as two products in Trilinos 13
  list.set("reuse: type", "RP");          // renew() keeps aggregates and prolongators: the matrix keeps its pattern
  list.set("smoother: type", "RELAXATION");
  Teuchos::ParameterList& smoother = list.sublist("smoother: params");
  smoother.set("relaxation: type", relaxation());
  smoother.set("relaxation: sweeps", strong ? strong_sweeps : 1);
  return list;
}

/// Changes the entries by less than the preconditioner notices, so that none is zero and no sum of them cancels.
/// Trilinos 13 leaves zeros of A out of the pattern of A P, on every level; where they have a value when the hierarchy
/// is renewed, it finds no place for the product and throws, maybe on one rank alone.
void make_generic(TpetraMatrix& matrix)
{
  constexpr double tiny = 1e-200, noise = 1e-10, golden = 0.6180339887498949;
  const auto values = matrix.getLocalMatrixDevice().values;
  Kokkos::parallel_for(
      "make generic", Kokkos::RangePolicy<ExecutionSpace>(0, values.extent(0)), KOKKOS_LAMBDA(const std::size_t k) {
        const double place = golden * static_cast<double>(k);
        const double share = place - std::floor(place); // in [0, 1), no two the same
        values(k) = values(k) == 0. ? tiny * (1. + share) : values(k) * (1. + noise * share);
      });
}

/// Opens what MueLu keeps to itself.
struct OpenHierarchy : MueLu::Hierarchy<double, LocalOrdinal, GlobalOrdinal, TpetraNode>
{
  using Closed = MueLu::Hierarchy<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
  static Teuchos::RCP<const MueLu::FactoryManagerBase> manager_of_level(const Closed& hierarchy, const int level)
  {
    return (hierarchy.*(&OpenHierarchy::GetLevelManager))(level);
  }
};

/// Makes the next setup multiply coarse matrices anew instead of into those it has: with threads at work Trilinos 13
/// does the latter on the host, one row after the other.
void forget_products(MueLu::Hierarchy<double, LocalOrdinal, GlobalOrdinal, TpetraNode>& hierarchy)
{
  for (int level = 1; level < hierarchy.GetNumLevels(); ++level)
  {
    const auto factory = OpenHierarchy::manager_of_level(hierarchy, level)->GetFactory("A");
    for (const char* const name : {"AP reuse data", "RAP reuse data"})
      hierarchy.GetLevel(level)->Delete(name, factory.get());
  }
}
} // namespace

struct Multigrid::Implementation
{
  Teuchos::RCP<TpetraMatrix> matrix;
  NodeBlocks blocks;
  BlockGaussSeidel smoother;
  Coarsening coarsening;
  Teuchos::RCP<Hierarchy> coarse_levels;    ///< for the coarse matrix
  unsigned int sweeps_before, sweeps_after; ///< the coarse correction

  Implementation(const Teuchos::RCP<TpetraMatrix>& matrix_, const TpetraMultiVector& modes,
                 const unsigned int block_size, const bool strong)
      : matrix(matrix_),
        blocks(make_node_blocks(*matrix, block_size)),
        smoother(*matrix, blocks),
        coarsening(*matrix, blocks, modes),
        sweeps_before(strong ? strong_sweeps : 0),
        sweeps_after(strong ? strong_sweeps : sweeps)
  {
    make_generic(*coarsening.matrix());
    const int n_ranks = matrix->getComm()->getSize();
    // What is on several ranks is factorised on a level below, which one rank has.
    const Tpetra::global_size_t few_rows = gathering(n_ranks).few_rows;
    const bool one_rank_factorises =
        n_ranks == 1 || (gathers_levels && coarsening.matrix()->getGlobalNumRows() > few_rows);
    Teuchos::ParameterList list = hierarchy_parameters(coarsening.n_modes(), strong, n_ranks,
                                                       one_rank_factorises ? Coarsest::factorised : Coarsest::smoothed);
    list.sublist("user data").set("Nullspace", coarsening.near_null_space());
    const Teuchos::RCP<TpetraOperator> coarse = coarsening.matrix();
    coarse_levels = MueLu::CreateTpetraPreconditioner<double, LocalOrdinal, GlobalOrdinal, TpetraNode>(coarse, list);
  }
};

Multigrid::Multigrid(std::unique_ptr<Implementation> implementation_) : implementation(std::move(implementation_)) {}

Multigrid::~Multigrid() = default;

Teuchos::RCP<const TpetraMap> Multigrid::getDomainMap() const { return implementation->matrix->getRowMap(); }
Teuchos::RCP<const TpetraMap> Multigrid::getRangeMap() const { return implementation->matrix->getRowMap(); }

Teuchos::RCP<Multigrid> Multigrid::build(const Teuchos::RCP<TpetraMatrix>& matrix,
                                         const Teuchos::RCP<TpetraMultiVector>& near_null_space,
                                         const unsigned int block_size, const bool strong, std::string& trouble)
{
  try
  {
    auto made = std::make_unique<Implementation>(matrix, *near_null_space, block_size, strong);
    return Teuchos::rcp(new Multigrid(std::move(made)));
  }
  catch (const std::bad_alloc&) // which no other preconditioner mends
  {
    throw;
  }
  catch (const std::exception& error) // MueLu throws if it finds no levels
  {
    trouble = error.what();
    rethrow_if_alone("multigrid");
    return Teuchos::null;
  }
}

bool Multigrid::renew()
{
  Implementation& at = *implementation;
  renew_node_blocks(*at.matrix, at.blocks);
  at.coarsening.renew();
  try
  {
    if (sweep_order() == SweepOrder::by_colour)
      forget_products(*at.coarse_levels->GetHierarchy());
    MueLu::ReuseTpetraPreconditioner<double, LocalOrdinal, GlobalOrdinal, TpetraNode>(at.coarsening.matrix(),
                                                                                      *at.coarse_levels);
  }
  catch (const std::bad_alloc&)
  {
    throw;
  }
  catch (const std::exception&)
  {
    rethrow_if_alone("multigrid");
    return false;
  }
  return true;
}

void Multigrid::apply(const TpetraMultiVector& x, TpetraMultiVector& y, Teuchos::ETransp, double, double) const
{
  const Implementation& at = *implementation;
  TpetraVector coarse_side(at.coarsening.matrix()->getRowMap()), correction(at.coarsening.matrix()->getRowMap());
  for (std::size_t i = 0; i < x.getNumVectors(); ++i)
  {
    const auto side = x.getVector(i);
    const auto solution = y.getVectorNonConst(i);
    solution->putScalar(0.);
    Teuchos::RCP<const TpetraVector> residual = side;
    if (at.sweeps_before > 0)
    {
      for (unsigned int sweep = 0; sweep < at.sweeps_before; ++sweep)
        at.smoother.sweep(*side, *solution);
      const auto rest = Teuchos::rcp(new TpetraVector(*side, Teuchos::Copy));
      at.matrix->apply(*solution, *rest, Teuchos::NO_TRANS, -1., 1.);
      residual = rest;
    }
    at.coarsening.restrict(*residual, coarse_side);
    at.coarse_levels->apply(coarse_side, correction);
    at.coarsening.add_prolonged(correction, *solution);
    for (unsigned int sweep = 0; sweep < at.sweeps_after; ++sweep)
      at.smoother.sweep(*side, *solution);
  }
}
} // namespace kedge
