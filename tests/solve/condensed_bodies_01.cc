// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Standard multipliers of ties, condensed for iterations: for noise on all right-hand sides, those of the
// multipliers as well, CG finds what MUMPS finds with the multipliers (relative difference of each block at
// most 1e-7). In 2D and 3D, degrees 1 to 3, with products in place of entries as well, for temperatures
// too; with moduli 1e4 apart; over a gap, where the equations of the destination are not symmetric; with
// hanging nodes that follow what follows; three bodies in a row. Where the destination is
// much stiffer and coarser, the multipliers stay.
//
// The product is symmetric and positive. The matrix that levels are made of gives a translation with a
// rotation of all bodies the forces that the product gives it (difference at most 1e-14 in each row, where E
// is 1 and 1e-8): weights of a few cells keep that. Else a rotation would cost what the stiff body resists.
//
// ranks: 1, 2, 3

#include "../../source/solve/group_system.h"

#include "assembled_scene.h"

#include <Epetra_Vector.h>

using namespace test;

namespace {

std::string clamped(const std::string &field, const std::string &value, const std::string &id)
{
  return set("Boundary conditions", "clamp") +
         subsection("Boundary condition clamp", set("Type", "value") + set("Field", field) +
                                                    set("Boundary ids", id) + set("Expression", value));
}

std::string body(const std::string &material, const std::string &cells, const std::string &degree,
                 const std::string &more = "", const std::string &more_of_mesh = "")
{
  return set("Material", material) + set("Degree", degree) + more + box(cells, more_of_mesh);
}

std::string elastic(const std::string &name, const std::string &modulus)
{
  return subsection("Material " + name,
                    subsection("Solid", set("Type", "linear elastic") + set("Young modulus", modulus) +
                                            set("Poisson ratio", "0.3")));
}

std::string tie(const std::string &name, const std::string &source, const std::string &destination)
{
  return subsection("Interface " + name, set("Type", "mortar") + set("Multiplier space", "standard") +
                                             set("Source", source) + set("Destination", destination));
}

/// Of the destination E is one.
std::string boxes(const std::string &modulus, const std::string &degree, const std::string &left,
                  const std::string &right, const std::string &more_of_right = "")
{
  const std::string zero = std::count(left.begin(), left.end(), ',') > 3 ? "0; 0; 0" : "0; 0";
  return set("Materials", "first, second") + set("Domains", "left, right") + set("Interfaces", "seam") +
         elastic("first", modulus) + elastic("second", "1") +
         subsection("Domain left", body("first", left, degree, clamped("displacement", zero, "0"))) +
         subsection("Domain right", body("second", right, degree, "", more_of_right)) +
         tie("seam", "left : 1", "right : 0");
}

/// @p more of the mesh of the destination
std::string elastic_of_degree_2(const std::string &more = "")
{
  return boxes("1e-4", "2", "2, 2, 2 : 0, 0, 0 : 1, 1, 1", "2, 3, 3 : 1, 0, 0 : 2, 1, 1", more);
}

std::string conductors()
{
  const auto conducting = [](const std::string &name, const std::string &k) {
    return subsection("Material " + name,
                      subsection("Heat", set("Type", "Fourier") + set("Conductivity", k)));
  };
  return set("Materials", "first, second") + set("Domains", "left, right") + set("Interfaces", "seam") +
         conducting("first", "1") + conducting("second", "20") +
         subsection("Domain left",
                    body("first", "4, 6, 6 : 0, 0, 0 : 1, 1, 1", "1", clamped("temperature", "0", "0"))) +
         subsection("Domain right", body("second", "4, 8, 8 : 1, 0, 0 : 2, 1, 1", "1")) +
         tie("seam", "left : 1", "right : 0");
}

std::string three_in_a_row(const std::string &degree)
{
  return set("Materials", "first, second") + set("Domains", "left, middle, right") +
         set("Interfaces", "seam, other") + elastic("first", "1e-4") + elastic("second", "1") +
         subsection("Domain left", body("second", "2, 4, 4 : 0, 0, 0 : 1, 1, 1", degree,
                                        clamped("displacement", "0; 0; 0", "0"))) +
         subsection("Domain middle", body("first", "2, 3, 3 : 1, 0, 0 : 2, 1, 1", degree)) +
         subsection("Domain right", body("second", "2, 5, 5 : 2, 0, 0 : 3, 1, 1", degree)) +
         tie("seam", "middle : 0", "left : 1") + tie("other", "middle : 1", "right : 0");
}

/// @param iteration: its solver
template <int dim>
void compare(const std::string &name, const std::string &prm, const std::string &iteration = "multigrid")
{
  AssembledScene<dim> assembled(prm);
  Vector b = assembled.system.owned_vector();
  const auto &blocks = assembled.scene.model.numbering->blocks();
  for (unsigned int block = 0; block < b.n_blocks(); ++block) {
    const double size = blocks[block].is_of_multipliers ? 1e-3 : 1;
    for (const auto i : b.block(block).locally_owned_elements())
      if (const auto dof = blocks[block].begin + i; !assembled.system.is_constrained(dof))
        b.block(block)(i) = size * noise(dof);
    b.block(block).compress(dealii::VectorOperation::insert);
  }
  std::vector<Vector> x(2, b);
  const std::vector<std::string> types = {"direct", iteration};
  for (unsigned int i = 0; i < 2; ++i) {
    LinearSolver solver(
        SceneText::root(SceneText::from_prm(set("Type", types[i]) + set("Relative tolerance", "1e-12"))),
        assembled.groups());
    assembled.give_matrix(solver);
    auto n_iterations = solver.solve(x[i], b);
    if (!n_iterations && solver.lacks_operator()) { // multipliers that stay need entries
      solver.forget_matrix();
      assembled.give_matrix(solver);
      n_iterations = solver.solve(x[i], b);
    }
    if (is_rank_0())
      std::cout << name << ": " << solver.description()[0] << std::endl;
    report("at most 60 iterations", n_iterations ? *n_iterations : 1e3, 60);
  }
  for (unsigned int block = 0; block < x[0].n_blocks(); ++block) {
    const double size = x[0].block(block).l2_norm();
    x[1].block(block) -= x[0].block(block);
    report("block " + std::to_string(block), x[1].block(block).l2_norm() / size, 1e-7);
  }
}

double product(const GroupOperator &K, const GroupVector &x, const GroupVector &y)
{
  GroupVector Ky(y);
  K.vmult(Ky, y);
  return x * Ky;
}

/// Of noise, at rows that lead.
GroupVector make_noise(const GroupOperator &K, const unsigned long first)
{
  GroupVector x = K.vector();
  for (const auto i : x.locally_owned_elements())
    x(i) = noise(first + i);
  x.compress(dealii::VectorOperation::insert);
  const Epetra_CrsMatrix &matrix = *K.matrix();
  for (int row = 0; row < matrix.NumMyRows(); ++row)
    if (matrix.NumMyEntries(row) == 1)
      x.trilinos_vector()[0][row] = 0;
  return x;
}

void check_operator()
{
  const AssembledScene<3> assembled(
      boxes("1e-8", "1", "3, 5, 5 : 0, 0, 0 : 1, 1, 1", "4, 8, 8 : 1, 0, 0 : 2, 1, 1"));
  GroupSystem group(assembled.groups()[0]);
  group.set_matrix(assembled.system.tangent());
  group.make_iterated([]() {});
  const GroupOperator &K = group.iterated();
  report("no multipliers", !group.iterated_facts().has_multipliers);
  const GroupVector x = make_noise(K, 0), y = make_noise(K, 1000);
  const double xKy = product(K, x, y), yKx = product(K, y, x), xKx = product(K, x, x), yKy = product(K, y, y);
  report("symmetric", std::abs(xKy - yKx) / std::sqrt(xKx * yKy), 1e-12);
  report("positive", xKx > 0 && yKy > 0);

  const Epetra_CrsMatrix &matrix = *K.matrix();
  const auto translations = group.iterated_facts().near_null_space(nullptr);
  const auto places = group.iterated_facts().known_places();
  for (unsigned int axis = 0; axis < 3; ++axis) {
    GroupVector motion = K.vector(), forces(motion);
    for (unsigned int row = 0; row < places.size(); ++row) {
      const auto is_of = [&](const unsigned int component) { // of one of the two bodies
        return translations[component][row] != 0 || translations[6 + component][row] != 0;
      };
      const auto &X = places[row].position;
      const unsigned int next = (axis + 1) % 3, last = (axis + 2) % 3;
      motion.trilinos_vector()[0][row] = matrix.NumMyEntries(row) == 1 ? 0
                                         : is_of(next)                 ? -X[last]
                                         : is_of(last)                 ? X[next]
                                                                       : 0.1;
    }
    K.vmult(forces, motion);
    Epetra_Vector of_matrix(matrix.RowMap());
    matrix.Multiply(false, Epetra_Vector(View, motion.trilinos_vector(), 0), of_matrix);
    double difference = 0;
    for (int row = 0; row < of_matrix.MyLength(); ++row)
      difference = std::max(difference, std::abs(of_matrix[row] - forces.trilinos_vector()[0][row]));
    report("forces of a rotation", difference, 1e-14);
  }
}

} // namespace

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  compare<2>("squares", boxes("1", "1", "6, 12 : 0, 0 : 1, 1", "8, 15 : 1, 0 : 2, 1"));
  compare<3>("cubes", boxes("1", "1", "3, 5, 5 : 0, 0, 0 : 1, 1, 1", "4, 8, 8 : 1, 0, 0 : 2, 1, 1"));
  compare<3>("degree 2", elastic_of_degree_2());
  compare<3>("degree 2", elastic_of_degree_2(), "matrix-free");
  compare<3>("finer in part", elastic_of_degree_2(set("Refine boxes", "1; 0; 0 : 2; 0.4; 1")), "matrix-free");
  compare<2>("degree 3", boxes("1e4", "3", "3, 6 : 0, 0 : 1, 1", "4, 8 : 1, 0 : 2, 1"), "matrix-free");
  compare<3>("gap", boxes("1", "1", "3, 5, 5 : 0, 0, 0 : 1, 1, 1", "4, 8, 8 : 1.02, 0, 0 : 2, 1, 1"));
  compare<3>("gap, soft source",
             boxes("1e-4", "1", "3, 5, 5 : 0, 0, 0 : 1, 1, 1", "4, 8, 8 : 1.02, 0, 0 : 2, 1, 1"));
  compare<3>("three in a row", three_in_a_row("1"));
  compare<3>("three in a row, degree 2", three_in_a_row("2"), "matrix-free");
  compare<3>("conductors", conductors());
  compare<3>("coarse and stiff",
             boxes("1e-4", "1", "4, 8, 8 : 0, 0, 0 : 1, 1, 1", "3, 5, 5 : 1, 0, 0 : 2, 1, 1"));
  check_operator();
}
