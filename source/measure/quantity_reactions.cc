// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What holds the prescribed unknowns: at each of their nodes the force r_i that is put into the body there
// (nodal_forces.h), for temperatures a heat; zero at all other nodes, between nodes by the shape functions.
// The resultant of a boundary is a probe with Boundary and Field (Carey, Chow & Seager 1985).
//
//     set Fields = solution, reactions

#include <dovetail/measure/quantity.h>

#include <deal.II/dofs/dof_tools.h>

namespace dovetail {

namespace {

template <int dim>
class NodalReactions : public Quantity<dim>
{
public:
  using Quantity<dim>::Quantity;

  std::vector<typename Quantity<dim>::Array> arrays() const override
  {
    std::vector<typename Quantity<dim>::Array> result;
    for (const Field &field : this->domain.fields())
      result.push_back({"reaction " + field.name, field.n_components});
    return result;
  }

  bool is_of_nodes() const override { return true; }

  void set_reactions(const Reactions<dim> &reactions) override
  {
    const auto &dof_handler = this->domain.dof_handler();
    const MPI_Comm communicator = this->domain.mesh().get_communicator();
    dealii::TrilinosWrappers::MPI::Vector owned(dof_handler.locally_owned_dofs(), communicator);
    for (const Field &field : this->domain.fields())
      for (const auto &[dof, at_node] : reactions.at_nodes(this->domain, field))
        owned(dof - this->domain.first_dof()) = at_node.force;
    owned.compress(dealii::VectorOperation::insert);
    forces.reinit(dof_handler.locally_owned_dofs(),
                  dealii::DoFTools::extract_locally_relevant_dofs(dof_handler), communicator);
    forces = owned;
  }

  void evaluate(DomainPoint<dim> &point, std::vector<double> &numbers) const override
  {
    const CellLayout<dim> &layout = this->domain.layout();
    for (unsigned int c = 0; c < this->domain.n_components(); ++c) {
      double sum = 0;
      for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
        sum += point.shape_values()[layout.first_shape(c) + a] *
               forces(point.dofs()[layout.index(c, a)] - this->domain.first_dof());
      numbers.push_back(sum);
    }
  }

private:
  dealii::TrilinosWrappers::MPI::Vector forces; ///< ghosted, in the numbering of the domain
};

const bool registered = add_quantity<NodalReactions>(
    "reactions", "", "what holds prescribed unknowns, at their nodes, by field [N or W]");

} // namespace

} // namespace dovetail
