// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/domain_point.h>

#include <limits>

namespace dovetail {

template <int dim>
DomainPoint<dim>::DomainPoint(const Domain<dim> &domain, const Vector &solution, const double t)
    : domain(domain), solution(solution), point(domain, t), unknowns(domain.dofs_per_cell())
{
}

template <int dim>
void DomainPoint<dim>::enter(const dealii::FEValuesBase<dim> &values, const BoundaryFace *face)
{
  points = &values;
  boundary_face = face;
  domain.cell_dofs(domain.dof_cell(typename dealii::Triangulation<dim>::active_cell_iterator(cell())),
                   cell_dofs);
  for (unsigned int i = 0; i < cell_dofs.size(); ++i)
    unknowns[i] = solution(cell_dofs[i]);
}

template <int dim>
void DomainPoint<dim>::move_to(const unsigned int q)
{
  point.reinit(*points, q, unknowns);
  has_fluxes = has_stress = false;
}

template <int dim>
void DomainPoint<dim>::shift(const unsigned int component, const unsigned int direction, const double amount)
{
  (direction == dim ? point.state.value[component] : point.state.gradient[component][direction]) += amount;
  has_fluxes = has_stress = false;
}

template <int dim>
const Response<dim> &DomainPoint<dim>::response()
{
  if (!has_fluxes && !point.evaluate(false))
    for (auto &flux : point.response.flux)
      for (unsigned int d = 0; d < dim; ++d)
        flux[d] = std::numeric_limits<double>::quiet_NaN();
  has_fluxes = true;
  return point.response;
}

template <int dim>
const dealii::Tensor<2, 3> &DomainPoint<dim>::cauchy_stress()
{
  if (!has_stress)
    stress = point.cauchy_stress();
  has_stress = true;
  return stress;
}

template <int dim>
dealii::Tensor<2, 3> DomainPoint<dim>::displacement_gradient() const
{
  return point.displacement_gradient();
}

template class DomainPoint<2>;
template class DomainPoint<3>;

} // namespace dovetail
