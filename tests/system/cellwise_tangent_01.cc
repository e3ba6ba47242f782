// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// The tangent of the cells as products, against the one with entries: K v, the diagonal, P^T K P and the part
// of prescribed values in the right-hand side, for linear and nonlinear laws, sources that depend on the
// unknown, centrifugal forces, an axis, conditions with a tangent, hanging nodes and each kind of tie,
// degrees 2 and 3. The size of a product, || |K| |v| ||, is one to four times that of the entries. The
// diagonal neglects products of unknowns that one follows: it is compared where nothing follows. A tie does
// not resist a translation, however far, but around an axis and where a conductivity depends on T.
//
// ranks: 1, 2, 3

#include "scene_model.h"

#include <dovetail/solve/prolongation.h>
#include <dovetail/system/cellwise_tangent.h>

#include <Epetra_CrsMatrix.h>

using namespace test;

namespace {

struct Case
{
  std::string name, material, of_left, of_right, tie;
  std::string top = "", of_mesh = "";
  bool has_followers = false, is_symmetric = true; ///< P^T K P is that of the symmetric part
  bool is_resisted = false;                        ///< a translation, by the tie
};

std::string value(const std::string &field, const std::string &ids, const std::string &expression)
{
  return set("Type", "value") + set("Field", field) + set("Boundary ids", ids) +
         set("Expression", expression);
}

template <int dim>
std::string scene(const Case &of, const unsigned int degree)
{
  const std::string cells[] = {dim == 2 ? "3, 2 : 0.5, 0 : 1, 1" : "2, 2, 1 : 0.5, 0, 0 : 1, 1, 1",
                               dim == 2 ? "2, 3 : 1, 0 : 2, 1" : "2, 1, 2 : 1, 0, 0 : 2, 1, 1"};
  const std::string common = set("Material", "one") + set("Degree", std::to_string(degree));
  return set("Materials", "one") + set("Domains", "left, right") + set("Interfaces", "seam") + of.top +
         subsection("Material one", of.material) +
         subsection("Domain left", common + box(cells[0], of.of_mesh) + of.of_left) +
         subsection("Domain right", common + box(cells[1]) + of.of_right) +
         subsection("Interface seam", of.tie + set("Source", "left : 1") + set("Destination", "right : 0"));
}

template <int dim>
struct System
{
  System(const std::string &prm, const bool has_entries) : scene(prm), system(scene.model)
  {
    system.choose_entries(std::vector<bool>(scene.model.field_groups().size(), has_entries));
    system.set_up(1.);
    Vector x = system.owned_vector();
    for (const auto i : scene.model.numbering->owned)
      x(i) = 1e-3 * noise(i);
    x.compress(dealii::VectorOperation::insert);
    system.begin_step(1., x);
    system.assemble(x, true);
  }

  SceneModel<dim> scene;
  BlockSystem<dim> system;
};

template <int dim>
double difference(const Vector &a, const Vector &b, const System<dim> &of,
                  const bool with_constrained = false)
{
  double largest = 0, error = 0;
  for (const auto i : of.scene.model.numbering->owned)
    if (with_constrained || !of.system.is_constrained(i)) {
      largest = std::max(largest, std::abs(double(a(i))));
      error = std::max(error, std::abs(a(i) - b(i)));
    }
  return dealii::Utilities::MPI::max(error, MPI_COMM_WORLD) /
         dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD);
}

/// Three rows to a column, mostly of another rank; none for unknowns that follow others.
Epetra_CrsMatrix aggregate(const Epetra_Map &rows, const std::vector<bool> &condensed)
{
  int n_own = (rows.NumMyElements() + 2) / 3;
  const Epetra_Map columns(-1, n_own, 0, rows.Comm());
  Epetra_CrsMatrix P(Copy, rows, 1);
  for (int i = 0; i < rows.NumMyElements(); ++i) {
    const int row = rows.GID(i), column = row * 7L % columns.NumGlobalElements();
    const double weight = noise(row);
    if (!condensed[i])
      P.InsertGlobalValues(row, 1, &weight, &column);
  }
  P.FillComplete(columns, rows);
  return P;
}

/// P^T A P v for a vector of noise
Epetra_Vector product(const Epetra_CrsMatrix &P, const Epetra_CrsMatrix &A, const Epetra_Vector &v)
{
  Epetra_Vector Pv(A.DomainMap()), APv(A.RangeMap()), result(P.DomainMap());
  P.Multiply(false, v, Pv);
  A.Multiply(false, Pv, APv);
  P.Multiply(true, APv, result);
  return result;
}

/// Of P^T K P v with and without entries, relative to the largest one.
double difference(const Prolongation &prolongation, const Epetra_CrsMatrix &all,
                  const Epetra_CrsMatrix &others, const PartOperator &cells)
{
  const Epetra_CrsMatrix P = *prolongation.matrix();
  Epetra_CrsMatrix nothing(Copy, P.DomainMap(), 0);
  nothing.FillComplete();
  Epetra_Vector v(P.DomainMap());
  for (int i = 0; i < v.MyLength(); ++i)
    v[i] = noise(P.DomainMap().GID(i));
  const Epetra_Vector expected = product(P, all, v);
  Epetra_Vector error = product(P, others, v), of_cells(P.DomainMap());
  cells.restricted(prolongation, nothing)->Multiply(false, v, of_cells);
  error.Update(1., of_cells, -1., expected, 1.);
  double largest = 0, largest_error = 0;
  expected.NormInf(&largest);
  error.NormInf(&largest_error);
  return largest_error / largest;
}

/// The largest force of the ties of all ranks on unknowns that are all the same, and far from zero.
template <int dim>
double force_of_translation(const System<dim> &of)
{
  double force = 0;
  const BlockMatrix &K = of.system.tangent();
  for (const auto &interface : of.scene.model.interfaces)
    for (const TiedField &field : interface->fields) {
      auto &cells =
          dynamic_cast<CellwiseTangent<dim> &>(const_cast<PartOperator &>(*K.part_operator(K.part_of(0))));
      const std::vector<double> x(K.m(), 1e9 / 3);
      std::vector<double> y(x.size(), 0.);
      if (const TieOperator<dim> *tie = cells.of_tie(*interface, field))
        tie->add_product(x.data(), y.data(), false);
      for (const double of_unknown : y)
        force = std::max(force, std::abs(of_unknown));
    }
  return dealii::Utilities::MPI::max(force, MPI_COMM_WORLD);
}

template <int dim>
void check(const Case &of, const unsigned int degree)
{
  const std::string prm = scene<dim>(of, degree), name = of.name + ", degree " + std::to_string(degree);
  System<dim> entries(prm, true), products(prm, false);
  report(name + ", loads",
         difference(entries.system.negative_residual(), products.system.negative_residual(), entries), 1e-12);
  Vector v = entries.system.owned_vector(), Kv = v, with_products = v;
  for (const auto i : entries.scene.model.numbering->owned)
    v(i) = entries.system.is_constrained(i) ? 0. : noise(3 * i);
  v.compress(dealii::VectorOperation::insert);
  entries.system.tangent().vmult(Kv, v);
  products.system.tangent().vmult(with_products, v);
  report(name + ", product", difference(Kv, with_products, entries), 1e-12);

  report(name + ", a translation is " + (of.is_resisted ? "resisted" : "free"),
         (force_of_translation(products) > 0) == of.is_resisted);
  const BlockMatrix &K = products.system.tangent();
  for (const bool is_smooth : {false, true}) {
    for (const auto i : entries.scene.model.numbering->owned)
      v(i) = entries.system.is_constrained(i) ? 0. : is_smooth ? 1. : noise(3 * i);
    v.compress(dealii::VectorOperation::insert);
    const std::vector<double> sizes = K.sizes_of_products(v),
                              of_entries = entries.system.tangent().sizes_of_products(v);
    for (unsigned int b = 0; b < K.n_block_rows(); ++b) {
      const double ratio = sizes[b] / of_entries[b];
      report(name + ", size of a " + (is_smooth ? "smooth" : "rough") + " product in block " +
                 std::to_string(b),
             std::abs(std::log2(ratio) - 1), 1);
    }
  }
  for (unsigned int b = 0; b < K.n_block_rows(); ++b) {
    const auto expected = entries.system.tangent().diagonal(b), found = K.diagonal(b);
    const dealii::types::global_dof_index first = K.get_row_indices().block_start(b);
    double error = 0, largest = 0;
    for (unsigned int i = 0; i < expected.size(); ++i)
      if (!entries.system.is_constrained(first + K.owned_unknowns()[b].nth_index_in_set(i))) {
        largest = std::max(largest, expected[i]);
        error = std::max(error, std::abs(expected[i] - found[i]));
      }
    largest = dealii::Utilities::MPI::max(largest, MPI_COMM_WORLD);
    if (!of.has_followers)
      report(name + ", diagonal of block " + std::to_string(b), error / largest, 1e-12);
    if (const unsigned int part = K.part_of(b); b == 0 && of.is_symmetric) {
      const Epetra_CrsMatrix &all = entries.system.tangent().part(part, part).trilinos_matrix(),
                             &others = K.part(part, part).trilinos_matrix();
      const Prolongation P(aggregate(all.RowMap(), K.part_operator(part)->condensed()));
      report(name + ", P^T K P", difference(P, all, others, *K.part_operator(part)), 1e-12);
    }
  }
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  const std::string nitsche = set("Type", "Nitsche"),
                    dual = set("Type", "mortar") + set("Multiplier space", "dual"),
                    pointwise = set("Type", "pointwise"),
                    resistance = set("Type", "contact resistance") + set("Joint stiffness", "0.7; 0.4");
  const std::string elastic =
                        subsection("Solid", set("Type", "linear elastic") + set("Young modulus", "2 + x*y") +
                                                set("Poisson ratio", "0.3")),
                    rubber = subsection("Solid", set("Type", "neo-Hookean") + set("Young modulus", "1") +
                                                     set("Poisson ratio", "0.3") + set("Density", "2")),
                    heat = subsection("Heat", set("Type", "Fourier") + set("Conductivity", "1 + T^2 + x"));
  const auto clamp = [](const std::string &field, const std::string &value_there) {
    return set("Boundary conditions", "clamp") +
           subsection("Boundary condition clamp", value(field, "0", value_there));
  };
  const std::string with_spring =
      set("Boundary conditions", "support") +
      subsection("Boundary condition support",
                 set("Type", "spring") + set("Boundary ids", "1") + set("Coefficient", "3; 2"));
  const std::string with_convection =
      set("Boundary conditions", "air") +
      subsection("Boundary condition air", set("Type", "convection") + set("Field", "temperature") +
                                               set("Boundary ids", "1") + set("Coefficient", "3") +
                                               set("Ambient", "1"));
  const std::string around_axis = set("Geometry", "axisymmetric"),
                    with_spin = subsection("Source", set("Angular velocity", "0.1") + set("Axis", "0; 0; 1")),
                    refined = set("Refine boxes", "0.8; 0 : 1; 0.4");
  for (const unsigned int degree : {2, 3}) {
    check<2>({"elastic", elastic, clamp("displacement", "0.01; 0.02"), with_spring, nitsche}, degree);
    check<3>({"rubber", rubber, clamp("displacement", "0.001; 0; 0") + with_spin, "", nitsche}, degree);
    check<3>(
        {"heat", heat, clamp("temperature", "0.5"), with_convection, nitsche, "", "", false, false, true},
        degree);
    check<2>({"around an axis", rubber, clamp("displacement", "0.001; 0"), "", nitsche + set("Theta", "0"),
              around_axis, "", false, false, true},
             degree);
    check<2>({"own sides", elastic, clamp("displacement", "0.01; 0.02"), with_spring,
              nitsche + set("Integrate on", "own sides") + set("Theta", "-1"), "", "", false, false},
             degree);
    check<2>(
        {"layer", elastic, clamp("displacement", "0.01; 0.02"), with_spring, resistance, "", refined, true},
        degree);
    check<3>({"refined", elastic, clamp("displacement", "0.01; 0.02; 0"), "",
              nitsche + set("Integrate on", "both"), "", set("Refine boxes", "0.8; 0; 0 : 1; 0.4; 1"), true},
             degree);
    check<2>(
        {"dual mortar", elastic, clamp("displacement", "0.01; 0.02"), with_spring, dual, "", refined, true},
        degree);
    check<2>({"pointwise", rubber, clamp("displacement", "0.001; 0.002"), "", pointwise, "", refined, true},
             degree);
  }
}
