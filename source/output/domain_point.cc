// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/domain/cell_terms.h>
#include <dovetail/output/domain_point.h>

#include <limits>

namespace dovetail {

template <int dim>
DomainPoint<dim>::DomainPoint(const Domain<dim> &domain, const Vector &solution, const double t)
    : domain(domain), solution(solution), at_point(domain.n_components()), fluxes(domain.n_components()),
      unknowns(domain.dofs_per_cell()), shape(domain.n_nodes()), gradient(domain.n_nodes())
{
  at_point.t = t;
}

template <int dim>
void DomainPoint<dim>::enter(const dealii::FEValuesBase<dim> &values, const BoundaryFace *face)
{
  points = &values;
  of_face = face;
  domain.cell_dofs(domain.dof_cell(typename dealii::Triangulation<dim>::active_cell_iterator(cell())),
                   cell_dofs);
  for (unsigned int i = 0; i < cell_dofs.size(); ++i)
    unknowns[i] = solution(cell_dofs[i]);
}

template <int dim>
void DomainPoint<dim>::move_to(const unsigned int q)
{
  for (unsigned int a = 0; a < shape.size(); ++a) {
    shape[a] = points->shape_value(a, q);
    gradient[a] = points->shape_grad(a, q);
  }
  at_point.X = points->quadrature_point(q);
  evaluate_state<dim>(domain.n_components(), shape.size(), shape.data(), gradient.data(), unknowns.data(),
                      at_point);
  has_fluxes = has_stress = false;
}

template <int dim>
const Response<dim> &DomainPoint<dim>::response()
{
  if (!has_fluxes && !domain.material.evaluate(at_point, false, fluxes))
    for (auto &flux : fluxes.flux)
      for (unsigned int d = 0; d < dim; ++d)
        flux[d] = std::numeric_limits<double>::quiet_NaN();
  has_fluxes = true;
  return fluxes;
}

template <int dim>
const dealii::Tensor<2, 3> &DomainPoint<dim>::cauchy_stress()
{
  if (!has_stress)
    stress = domain.material.cauchy_stress(at_point);
  has_stress = true;
  return stress;
}

template <int dim>
dealii::Tensor<2, 3> DomainPoint<dim>::displacement_gradient() const
{
  const Field *displacement = domain.material.find_field("displacement");
  Assert(displacement != nullptr, dealii::ExcMessage("A material without a solid law does not deform."));
  dealii::Tensor<2, 3> H;
  for (unsigned int i = 0; i < dim; ++i)
    for (unsigned int J = 0; J < dim; ++J)
      H[i][J] = at_point.gradient[displacement->first_component + i][J];
  return H;
}

template class DomainPoint<2>;
template class DomainPoint<3>;

} // namespace dovetail
