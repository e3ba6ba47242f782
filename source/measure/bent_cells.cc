// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors

#include <dovetail/measure/bent_cells.h>
#include <dovetail/measure/domain_point.h>

#include <deal.II/base/mpi.h>
#include <deal.II/base/symmetric_tensor.h>

#include <cmath>
#include <sstream>
#include <string>

namespace dovetail {

namespace {

const NoteName of_bent_cells("bent cells",
                             "a metal that yields or creeps bends with one cell across its height");

const unsigned int largest_degree = 2; ///< four Gauss points and more err by 6 % at most
const double smallest_strain = 0.1;    ///< of the deviator of the whole strain
const double largest_share = 0.5;      ///< of the inelastic strain that turns its sign within cells

/// Integrals over a body.
struct InelasticStrain
{
  double of_cells = 0;  ///< sum over the cells of |integral of eps_p|
  double of_points = 0; ///< of |eps_p|
  double whole = 0;     ///< of the deviator of the strain

  double share_of_turning() const { return 1 - of_cells / of_points; }
  bool is_bending() const
  {
    return of_points > smallest_strain * whole && share_of_turning() > largest_share;
  }
};

/// "plastic strain", "creep strain".
bool is_inelastic_strain(const InternalVariable &variable)
{
  const std::string end = " strain";
  const std::size_t n = variable.name.size();
  return variable.n_components == 9 && n > end.size() && variable.name.compare(n - end.size(), n, end) == 0;
}

/// |dev E|, with Green's strain at large strain.
double size_of_strain(const dealii::Tensor<2, 3> &H, const bool is_large)
{
  return deviator(symmetrize(is_large ? H + 0.5 * transpose(H) * H : H)).norm();
}

/// @param first component of eps_p in the memory
template <int dim>
InelasticStrain inelastic_strain(const Domain<dim> &domain, const unsigned int first, const Vector &solution,
                                 const double t)
{
  const bool is_large = domain.material.has_large_strain();
  InelasticStrain result;
  DomainPoint<dim> point(domain, solution, t);
  dealii::FEValues<dim> values(domain.mapping(), domain.layout().shape_element(), domain.cell_quadrature(),
                               DomainPoint<dim>::needed() | dealii::update_JxW_values);
  for (const auto &cell : domain.dof_handler().active_cell_iterators())
    if (cell->is_locally_owned()) {
      values.reinit(typename dealii::Triangulation<dim>::active_cell_iterator(cell));
      point.enter(values);
      dealii::Tensor<2, 3> of_cell;
      for (const unsigned int q : values.quadrature_point_indices()) {
        point.move_to(q);
        const double *component = point.state().memory.accepted.data() + first;
        dealii::Tensor<2, 3> eps_p;
        for (unsigned int i = 0; i < 3; ++i)
          for (unsigned int j = 0; j < 3; ++j)
            eps_p[i][j] = *component++;
        const double dV = domain.measure(values, q);
        of_cell += dV * eps_p;
        result.of_points += dV * eps_p.norm();
        result.whole += dV * size_of_strain(point.displacement_gradient(), is_large);
      }
      result.of_cells += of_cell.norm();
    }
  return result;
}

InelasticStrain sum(InelasticStrain strain, const MPI_Comm &communicator)
{
  for (double *const integral : {&strain.of_cells, &strain.of_points, &strain.whole})
    *integral = dealii::Utilities::MPI::sum(*integral, communicator);
  return strain;
}

std::string in_words(const std::string &body, const std::string &variable, const InelasticStrain &strain)
{
  std::ostringstream words;
  words
      << body << ": " << std::lround(100 * strain.share_of_turning()) << " % of its " << variable
      << " turns its sign within cells, as in a body that bends with one cell across its height. The two or "
         "three points there miss up to 15 % of the moment at which it flows, and its displacement may err "
         "by far more. Refine the mesh across, or set Degree = 3";
  return words.str();
}

} // namespace

template <int dim>
NoteList explain_bent_cells(const Model<dim> &model, const Vector &solution, const double t)
{
  NoteList notes;
  for (const auto &domain : model.domains) {
    unsigned int first = 0;
    if (domain->degree > largest_degree || domain->material.solid_field() == nullptr)
      continue;
    for (const InternalVariable &variable : domain->material.internal_variables()) {
      if (is_inelastic_strain(variable))
        if (const InelasticStrain strain =
                sum(inelastic_strain(*domain, first, solution, t), model.communicator);
            strain.is_bending())
          notes.push_back(of_bent_cells(in_words(domain->name, variable.name, strain)));
      first += variable.n_components;
    }
  }
  return notes;
}

template NoteList explain_bent_cells(const Model<2> &, const Vector &, double);
template NoteList explain_bent_cells(const Model<3> &, const Vector &, double);

} // namespace dovetail
