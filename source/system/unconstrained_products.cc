// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/system/unconstrained_products.h>

#include <deal.II/base/mpi.h>

namespace dovetail {

namespace {

using Index = dealii::types::global_dof_index;

/// Adds what one cell, one group of points or one term of a multiplier has.
class Sums
{
public:
  Sums(const Vector &x, const std::vector<Vector> &all_w, UnconstrainedProducts &products)
      : x(x), all_w(all_w), products(products)
  {
  }

  /// Its unknowns, and room for its residual and tangent.
  void enter(const std::vector<Index> &dofs)
  {
    unknowns.resize(dofs.size());
    x.extract_subvector_to(dofs.begin(), dofs.end(), unknowns.begin());
    residual.assign(dofs.size(), 0.);
    tangent.reinit(dofs.size(), dofs.size());
  }

  void add(const std::vector<Index> &dofs)
  {
    for (unsigned int i = 0; i < dofs.size(); ++i)
      products.residual(dofs[i]) += residual[i];
    std::vector<double> weights(dofs.size());
    for (unsigned int k = 0; k < all_w.size(); ++k) {
      all_w[k].extract_subvector_to(dofs.begin(), dofs.end(), weights.begin());
      for (unsigned int j = 0; j < dofs.size(); ++j) {
        double sum = 0;
        for (unsigned int i = 0; i < dofs.size(); ++i)
          sum += tangent(i, j) * weights[i];
        products.transposed[k](dofs[j]) += sum;
      }
    }
  }

  dealii::FullMatrix<double> *tangent_if_asked() { return all_w.empty() ? nullptr : &tangent; }

  std::vector<double> unknowns, residual;

private:
  const Vector &x;
  const std::vector<Vector> &all_w;
  UnconstrainedProducts &products;
  dealii::FullMatrix<double> tangent;
};

template <int dim>
bool add_cells(const Domain<dim> &domain, const double t, Sums &sums)
{
  CellTerms<dim> terms(domain);
  bool is_defined = true;
  std::vector<Index> dofs;
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      domain.cell_dofs(cell, dofs);
      sums.enter(dofs);
      is_defined =
          terms.assemble(cell, t, sums.unknowns, sums.residual, sums.tangent_if_asked()) && is_defined;
      sums.add(dofs);
    }
  return is_defined;
}

template <int dim>
bool add_interface(const Interface<dim> &interface, const double t, Sums &sums)
{
  const TieParts<dim> parts = interface.tie().parts();
  bool is_defined = true;
  std::vector<Index> dofs;
  if (parts.point_terms != nullptr)
    for (const auto &group : interface.pairing().groups) {
      interface.group_dofs(group, dofs);
      sums.enter(dofs);
      is_defined = parts.point_terms->assemble(interface, group, t, sums.unknowns, sums.residual,
                                               sums.tangent_if_asked()) &&
                   is_defined;
      sums.add(dofs);
    }
  for (unsigned int i = 0; parts.multipliers != nullptr && i < parts.multipliers->n_terms(); ++i) {
    const std::vector<Index> &term_dofs = parts.multipliers->term_dofs(i);
    sums.enter(term_dofs);
    parts.multipliers->assemble_term(i, sums.unknowns, sums.residual, sums.tangent_if_asked());
    sums.add(term_dofs);
  }
  return is_defined;
}

} // namespace

template <int dim>
std::optional<UnconstrainedProducts> unconstrained_products(const Model<dim> &model, const double t,
                                                            const Vector &x, const std::vector<Vector> &all_w)
{
  const auto owned = model.numbering->split(model.numbering->owned);
  UnconstrainedProducts products;
  products.residual.reinit(owned, model.communicator);
  for (unsigned int k = 0; k < all_w.size(); ++k)
    products.transposed.emplace_back(owned, model.communicator);
  Sums sums(x, all_w, products);
  bool is_defined = true;
  for (const auto &domain : model.domains)
    is_defined = add_cells(*domain, t, sums) && is_defined;
  for (const auto &interface : model.interfaces)
    if (interface->is_active(t))
      is_defined = add_interface(*interface, t, sums) && is_defined;
  products.residual.compress(dealii::VectorOperation::add);
  for (Vector &product : products.transposed)
    product.compress(dealii::VectorOperation::add);
  if (dealii::Utilities::MPI::min(is_defined ? 1 : 0, model.communicator) == 0)
    return {};
  return products;
}

template std::optional<UnconstrainedProducts> unconstrained_products(const Model<2> &, double, const Vector &,
                                                                     const std::vector<Vector> &);
template std::optional<UnconstrainedProducts> unconstrained_products(const Model<3> &, double, const Vector &,
                                                                     const std::vector<Vector> &);

} // namespace dovetail
