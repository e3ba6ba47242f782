// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/system/vector.h>

#include <deal.II/dofs/dof_tools.h>

namespace dovetail {

void keep_owned_values(Vector &x)
{
  for (unsigned int b = 0; b < x.n_blocks(); ++b) {
    x.block(b).trilinos_vector().setIgnoreNonLocalEntries(true);
    x.block(b).compress(dealii::VectorOperation::insert);
    x.block(b).trilinos_vector().setIgnoreNonLocalEntries(false);
  }
}

template <int dim>
dealii::TrilinosWrappers::MPI::Vector domain_vector(const Domain<dim> &domain, const Vector &ghosted)
{
  const MPI_Comm communicator = ghosted.block(0).get_mpi_communicator();
  const dealii::IndexSet &owned_dofs = domain.dof_handler().locally_owned_dofs();
  const dealii::IndexSet relevant_dofs =
      dealii::DoFTools::extract_locally_relevant_dofs(domain.dof_handler());
  dealii::TrilinosWrappers::MPI::Vector owned(owned_dofs, communicator),
      result(owned_dofs, relevant_dofs, communicator);
  for (const auto dof : owned_dofs)
    owned(dof) = ghosted(domain.first_dof() + dof);
  owned.compress(dealii::VectorOperation::insert);
  result = owned;
  return result;
}

template dealii::TrilinosWrappers::MPI::Vector domain_vector(const Domain<2> &, const Vector &);
template dealii::TrilinosWrappers::MPI::Vector domain_vector(const Domain<3> &, const Vector &);

} // namespace dovetail
