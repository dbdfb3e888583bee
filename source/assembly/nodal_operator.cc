#include <kedge/assembly/nodal_operator.h>

namespace kedge
{
NodalOperator::NodalOperator(const System& system_, Product product_)
    : system(system_),
      product(std::move(product_)),
      direction(system.graph().row_map),
      result(system.graph().row_map),
      local_result(system.make_nodal_vector())
{
}

void NodalOperator::apply(const TpetraMultiVector& x, TpetraMultiVector& y, Teuchos::ETransp, const double alpha,
                          const double beta) const
{
  for (std::size_t i = 0; i < x.getNumVectors(); ++i)
  {
    const auto from = x.getVector(i);
    Tpetra::deep_copy(direction, *from);
    system.zero_constrained(direction);
    Kokkos::deep_copy(local_result, 0.);
    product(system.spread(direction), local_result);
    system.collect(local_result, result);
    system.keep_constrained(*from, result);
    y.getVectorNonConst(i)->update(alpha, result, beta);
  }
}
} // namespace kedge
