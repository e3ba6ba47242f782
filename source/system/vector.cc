// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/vector.h>

#include <deal.II/dofs/dof_tools.h>

namespace dovetail {

template <int dim>
dealii::LinearAlgebra::distributed::Vector<double> domain_vector(const Domain<dim> &domain, const Vector &ghosted)
{
  dealii::IndexSet relevant;
  dealii::DoFTools::extract_locally_relevant_dofs(domain.dof_handler(), relevant);
  dealii::LinearAlgebra::distributed::Vector<double> result(domain.dof_handler().locally_owned_dofs(), relevant,
                                                            ghosted.block(0).get_mpi_communicator());
  for (const auto dof : domain.dof_handler().locally_owned_dofs())
    result(dof) = ghosted(domain.first_dof + dof);
  result.update_ghost_values();
  return result;
}

template dealii::LinearAlgebra::distributed::Vector<double> domain_vector(const Domain<2> &, const Vector &);
template dealii::LinearAlgebra::distributed::Vector<double> domain_vector(const Domain<3> &, const Vector &);

} // namespace dovetail
