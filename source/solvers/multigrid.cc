#include <MueLu_CreateTpetraPreconditioner.hpp>
#include <cmath>
#include <kedge/base/failure.h>
#include <kedge/solvers/block_gauss_seidel.h>
#include <kedge/solvers/multigrid.h>

namespace kedge
{
namespace
{
using Hierarchy = MueLu::TpetraOperator<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using XpetraMatrix = Xpetra::Matrix<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using XpetraVectors = Xpetra::TpetraMultiVector<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;
using Utilities = MueLu::Utilities<double, LocalOrdinal, GlobalOrdinal, TpetraNode>;

/// Of the finest level's smoother after the coarse correction. On a plate pulled through sand two take a quarter fewer
/// iterations than one, each dearer by a seventh.
constexpr unsigned int sweeps = 2;
/// On all levels, before and after the coarse correction, where those do not do.
constexpr int strong_sweeps = 4;
/// Rows from which a hierarchy has two levels below the finest one.
constexpr std::size_t large_enough_to_gather = 20000;

/// How the coarsest level is solved.
enum class Coarsest
{
  factorised, ///< on one rank
  smoothed    ///< where it lies
};

/// Of the levels below the finest one. Where threads work at once, the form by two stages takes as many iterations as
/// that by colours and is set up in a third of the time (plate pulled through sand).
const char* relaxation()
{
  return sweep_order() == SweepOrder::by_number ? "Symmetric Gauss-Seidel" : "Two-stage Symmetric Gauss-Seidel";
}

Teuchos::ParameterList hierarchy_parameters(const unsigned int block_size, const bool strong, const bool parallel,
                                            const Coarsest coarsest)
{
  Teuchos::ParameterList list;
  list.set("verbosity", "none");
  list.set("number of equations", static_cast<int>(block_size));
  // Measured on yielding sand and on an elastic cube of 100 000 dofs: smoothing the prolongators saves hardly an
  // iteration but makes set-up 2.5 times dearer.
  list.set("multigrid algorithm", strong ? "sa" : "unsmoothed");
  list.set("smoother: pre or post", strong ? "both" : "post");
  list.set("aggregation: type", "uncoupled");
  list.set("aggregation: drop tol", 0.0);
  list.set("coarse: max size", coarsest == Coarsest::smoothed ? 300 : 1000);
  if (parallel && coarsest == Coarsest::factorised)
  {
    // Neighbouring ranks have neighbouring parts, so blocks of the rows' numbers are parts of the soil. The level below
    // the finest one stays as it is, for apply() takes its vectors.
    list.set("repartition: enable", true);
    list.set("repartition: partitioner", "zoltan2");
    list.sublist("repartition: params").set("algorithm", "block");
    list.set("repartition: start level", 2);
    list.set("repartition: min rows per proc", 1000);
    list.set("repartition: target rows per proc", 2000);
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
  list.set("max levels", 6);
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
        const double share = std::fmod(golden * static_cast<double>(k), 1.); // in [0, 1), no two the same
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
  unsigned int block_size;
  Teuchos::RCP<Hierarchy> hierarchy;
  Teuchos::RCP<const TpetraMatrix> prolongator; ///< to the finest level; null if that is the only one
  std::unique_ptr<BlockGaussSeidel> smoother;   ///< of the finest level, so too
  unsigned int sweeps_before, sweeps_after;     ///< the coarse correction

  void set_up_finest_level()
  {
    const auto levels = hierarchy->GetHierarchy();
    if (levels->GetNumLevels() == 1)
      return;
    prolongator = Utilities::Op2TpetraCrs(levels->GetLevel(1)->Get<Teuchos::RCP<XpetraMatrix>>("P"));
    if (smoother == nullptr)
      smoother = std::make_unique<BlockGaussSeidel>(*matrix, block_size);
    else
      smoother->renew(*matrix);
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
  auto made = std::make_unique<Implementation>();
  made->matrix = matrix;
  made->block_size = block_size;
  made->sweeps_before = strong ? strong_sweeps : 0;
  made->sweeps_after = strong ? strong_sweeps : sweeps;
  make_generic(*matrix);
  const Teuchos::RCP<TpetraOperator> as_operator = matrix;
  const bool parallel = matrix->getComm()->getSize() > 1;
  const auto make = [&](const Coarsest coarsest)
  {
    Teuchos::ParameterList list = hierarchy_parameters(block_size, strong, parallel, coarsest);
    list.sublist("user data").set("Nullspace", near_null_space);
    made->hierarchy =
        MueLu::CreateTpetraPreconditioner<double, LocalOrdinal, GlobalOrdinal, TpetraNode>(as_operator, list);
  };
  try
  {
    const bool one_rank_factorises = !parallel || matrix->getGlobalNumRows() > large_enough_to_gather;
    make(one_rank_factorises ? Coarsest::factorised : Coarsest::smoothed);
  }
  catch (const std::exception& error) // MueLu throws if it finds none
  {
    trouble = error.what();
    rethrow_if_alone("multigrid");
    return Teuchos::null;
  }
  made->set_up_finest_level();
  return Teuchos::rcp(new Multigrid(std::move(made)));
}

bool Multigrid::renew()
{
  Implementation& at = *implementation;
  try
  {
    if (sweep_order() == SweepOrder::by_colour)
      forget_products(*at.hierarchy->GetHierarchy());
    MueLu::ReuseTpetraPreconditioner<double, LocalOrdinal, GlobalOrdinal, TpetraNode>(at.matrix, *at.hierarchy);
  }
  catch (const std::exception&)
  {
    rethrow_if_alone("multigrid");
    return false;
  }
  at.set_up_finest_level();
  return true;
}

void Multigrid::apply(const TpetraMultiVector& x, TpetraMultiVector& y, Teuchos::ETransp mode, const double alpha,
                      const double beta) const
{
  const Implementation& at = *implementation;
  if (at.smoother == nullptr)
    return at.hierarchy->apply(x, y, mode, alpha, beta);
  const auto coarse_map = at.prolongator->getDomainMap();
  const auto coarse_side = Teuchos::rcp(new TpetraMultiVector(coarse_map, 1)),
             correction = Teuchos::rcp(new TpetraMultiVector(coarse_map, 1));
  for (std::size_t i = 0; i < x.getNumVectors(); ++i)
  {
    const auto side = x.getVector(i);
    const auto solution = y.getVectorNonConst(i);
    solution->putScalar(0.);
    Teuchos::RCP<const TpetraVector> residual = side;
    if (at.sweeps_before > 0)
    {
      for (unsigned int sweep = 0; sweep < at.sweeps_before; ++sweep)
        at.smoother->sweep(*side, *solution);
      const auto rest = Teuchos::rcp(new TpetraVector(*side, Teuchos::Copy));
      at.matrix->apply(*solution, *rest, Teuchos::NO_TRANS, -1., 1.);
      residual = rest;
    }
    at.prolongator->apply(*residual, *coarse_side, Teuchos::TRANS);
    XpetraVectors on_right(coarse_side), on_left(correction);
    at.hierarchy->GetHierarchy()->Iterate(on_right, on_left, 1, true, 1);
    at.prolongator->apply(*correction, *solution, Teuchos::NO_TRANS, 1., 1.);
    for (unsigned int sweep = 0; sweep < at.sweeps_after; ++sweep)
      at.smoother->sweep(*side, *solution);
  }
}
} // namespace kedge
