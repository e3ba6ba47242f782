// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Fields with spaces of their own beside the temperature of degree p: salt of degree p - 1, which diffuses,
// and a phase of degree p - 1 without continuity, which follows from both in each cell. Layout and shape
// functions; the tangent against differences; local refinement; on two bodies whose meshes do not match, with
// every tie: polynomials of these degrees are exact, and a smooth solution has the rates p + 1, p and p. What
// a discontinuous field cannot do is wrong input.
//
// ranks: 1, 3

#include "../system/scene_model.h"

#include <dovetail/domain/cell_points.h>
#include <dovetail/domain/quadrature.h>
#include <dovetail/domain/shapes.h>
#include <dovetail/material/diffusion_term.h>
#include <dovetail/material/gradient_law.h>
#include <dovetail/material/material_part.h>
#include <dovetail/material/reaction_term.h>
#include <dovetail/run/initial_values.h>
#include <dovetail/run/simulation.h>
#include <dovetail/scene/user_error.h>

#include <fstream>

using namespace test;

/// `subsection Brine`: the salt, and the phase with 0 = Formula.
template <int dim>
class Brine : public MaterialPart<dim>
{
public:
  explicit Brine(const Section &material) : MaterialPart<dim>(material), section(material.subsection("Brine"))
  {
  }

  std::vector<Field> fields() const override
  {
    if (!section.documenting() && !section.is_set("Diffusivity"))
      return {};
    return {{"salt", 1, 0, "brine", "salt", "", -1}, {"phase", 1, 0, "phase", "phase", "", -1, false}};
  }

  void add_terms(const std::vector<Field> &all, typename MaterialPart<dim>::Terms &terms) const override
  {
    for (const Field &field : all) {
      if (field.law == "brine")
        terms.push_back(std::make_unique<DiffusionTerm<dim>>(
            field, all,
            std::make_unique<GradientLaw<SpeciesLaw>>(section, "Diffusivity", "Of the salt [m^2/s]",
                                                      symbols_of(all)),
            "Fick"));
      if (field.law == "brine" || field.law == "phase") {
        const std::string entry = field.law == "brine" ? "Reaction" : "Formula";
        const Expression formula =
            section.read_expression(entry, "0", {1}, "Of scalars [1/(m^3 s)]", symbols_of(all));
        if (!formula.is_zero())
          terms.push_back(std::make_unique<ReactionTerm<dim>>(field, all, section, entry, formula));
      }
    }
  }

private:
  const Section section;
};

struct Case
{
  unsigned int dim = 2;
  bool simplices = false;
  std::string degree = "2", tie = "Nitsche", more_of_tie = "";
  std::string temperature = "1", salt = "1", phase = "1", source = "0"; ///< exact
  std::string conductivity = "2", diffusivity = "1", reaction = "0", formula = "1 - phase";
  unsigned int n = 1, n_right = 3;                   ///< of cells: 2 n and n_right n
  std::string of_salt = "", initial = "", more = ""; ///< entries
};

std::string value(const std::string &field, const std::string &ids, const std::string &expression,
                  const std::string &more = "")
{
  return subsection("Boundary condition " + field, set("Type", "value") + set("Field", field) +
                                                       set("Boundary ids", ids) +
                                                       set("Expression", expression) + more);
}

std::string body(const Case &of, const std::string &name, const unsigned int x, const unsigned int n)
{
  const bool is_3d = of.dim == 3;
  const std::string cells = std::to_string(n * of.n), x0 = std::to_string(x), x1 = std::to_string(x + 1),
                    ids = (x == 0 ? "0" : "1") + std::string(is_3d ? ", 2, 3, 4, 5" : ", 2, 3");
  return subsection("Domain " + name,
                    set("Material", "brine") + set("Degree", of.degree) +
                        set("Boundary conditions", "temperature, salt") +
                        value("temperature", ids, of.temperature) + value("salt", ids, of.salt, of.of_salt) +
                        subsection("Initial", of.initial) + subsection("Source", set("salt", of.source)) +
                        subsection("Exact", set("temperature", of.temperature) + set("salt", of.salt) +
                                                set("phase", of.phase)) +
                        box(cells + ", " + cells + (is_3d ? ", 1 : " : " : ") + x0 +
                                (is_3d ? ", 0, 0 : " : ", 0 : ") + x1 + (is_3d ? ", 1, 1" : ", 1"),
                            of.simplices ? set("Cells", "simplices") : ""));
}

/// Without the dimension.
std::string scene(const Case &of)
{
  return set("Materials", "brine") + set("Domains", "left, right") + set("Interfaces", "seam") +
         subsection("Material brine",
                    subsection("Heat", set("Type", "Fourier") + set("Conductivity", of.conductivity)) +
                        subsection("Brine", set("Diffusivity", of.diffusivity) +
                                                set("Reaction", of.reaction) + set("Formula", of.formula))) +
         body(of, "left", 0, 2) + body(of, "right", 1, of.n_right) +
         subsection("Interface seam", set("Type", of.tie) + set("Source", "left : 1") +
                                          set("Destination", "right : 0") + of.more_of_tie) +
         subsection("Output", set("Paraview", "false") + set("Directory", "out")) + of.more;
}

/// L2 errors of temperature, salt and phase, over both bodies.
nlohmann::json last_report;

template <int dim>
std::array<double, 3> errors_of(const Case &of)
{
  std::ofstream nowhere;
  auto *const terminal = std::cout.rdbuf(nowhere.rdbuf());
  bool is_converged;
  {
    Simulation<dim> simulation(SceneText::from_prm(set("Dimension", std::to_string(dim)) + scene(of)),
                               MPI_COMM_WORLD);
    is_converged = simulation.run();
  }
  std::cout.rdbuf(terminal);
  nlohmann::json &report = last_report;
  std::ifstream("out/report.json") >> report;
  MPI_Barrier(MPI_COMM_WORLD);
  std::array<double, 3> errors = {{1e300, 1e300, 1e300}};
  const std::array<std::string, 3> fields = {{"temperature", "salt", "phase"}};
  for (unsigned int f = 0; is_converged && f < 3; ++f) {
    double square = 0;
    for (const std::string name : {"left", "right"})
      square += std::pow(report["domains"][name]["errors"][fields[f]]["L2"].get<double>(), 2);
    errors[f] = std::sqrt(square);
  }
  return errors;
}

const std::vector<std::array<std::string, 3>> ties = {
    {{"theta 1", "Nitsche", ""}},
    {{"theta 0", "Nitsche", set("Theta", "0")}},
    {{"dual mortar", "mortar", ""}},
    {{"standard mortar", "mortar", set("Multiplier space", "standard")}},
    {{"pointwise", "pointwise", ""}}};

template <int dim>
void check_patch(const bool simplices, const std::string &degree)
{
  Case of;
  of.dim = dim;
  of.simplices = simplices;
  of.degree = degree;
  const bool is_cubic = degree == "3";
  of.temperature = is_cubic ? "1 + x^3 - 3*x*y^2" : "1 + x + x^2 - y^2";
  of.salt = is_cubic ? "2 + x*y" : "2 - x + y";
  of.phase = "2*(" + of.salt + ") + 1";
  of.formula = "1 + 2*salt - phase";
  for (const auto &[name, type, more] : ties) {
    const bool is_for_simplices = name == "theta 0" || name == "standard mortar";
    if (dim == 3 && simplices != is_for_simplices)
      continue; // one is enough; and no dual mortar on tetrahedra
    of.tie = type;
    of.more_of_tie = more;
    of.n_right = type == "pointwise" ? 4 : 3; // exact only where the destination's trace holds the source's
    const auto errors = errors_of<dim>(of);
    report(std::to_string(dim) + "D, " + (simplices ? "simplices" : "hypercubes") + ", degree " + degree +
               ", " + name + ": exact",
           *std::max_element(errors.begin(), errors.end()), 1e-11);
  }
}

void check_rates(const bool simplices)
{
  Case of;
  of.simplices = simplices;
  of.temperature = "exp(x)*cos(y)";
  of.salt = "exp(y)*cos(x)";
  of.phase = "exp(x)*cos(y)*exp(y)*cos(x)";
  of.reaction = "T - salt";
  of.source = "exp(y)*cos(x) - exp(x)*cos(y)";
  of.formula = "T*salt - phase";
  for (const auto &[name, type, more] : ties) {
    if (name != (simplices ? "theta 0" : "dual mortar"))
      continue;
    of.tie = type;
    of.more_of_tie = more;
    of.n = simplices ? 1 : 2;
    const auto coarse = errors_of<2>(of);
    of.n *= 2;
    const auto fine = errors_of<2>(of);
    const std::array<double, 3> least = {
        {name == "pointwise" ? 1.3 : 2.7, name == "pointwise" ? 1.3 : 1.8, 1.8}};
    for (unsigned int f = 0; f < 3; ++f)
      report(std::string(simplices ? "triangles, " : "quadrilaterals, ") + name + ": rate of field " +
                 std::to_string(f),
             least[f] - std::log2(coarse[f] / fine[f]), 0.);
  }
}

/// Elements, indices and shape functions.
template <int dim>
void check_layout(const bool simplices)
{
  Case of;
  of.dim = dim;
  of.simplices = simplices;
  const SceneModel<dim> built(scene(of));
  const Domain<dim> &domain = *built.model.domains[0];
  const CellLayout<dim> &layout = domain.layout();
  print(std::to_string(dim) + (simplices ? "D simplices" : "D") + ": spaces, unknowns, shape functions",
        {double(layout.n_spaces()), double(layout.size()), double(layout.n_shapes()),
         double(domain.dof_handler().n_dofs())});
  dealii::FEValues<dim> values(
      domain.mapping(), layout.shape_element(), gauss_rule<dim>(domain.cell_shape(), 2),
      dealii::update_values | dealii::update_gradients | dealii::update_quadrature_points);
  ShapeEvaluator<dim> shapes(domain);
  std::vector<double> unknowns(layout.size()), at_point(layout.n_shapes());
  std::vector<dealii::Tensor<1, dim>> gradients(layout.n_shapes());
  // the temperature is x, the salt y, the phase 2
  double error = 0, difference = 0;
  CellPoints<dim> point(domain, 0);
  for (const auto &cell : domain.mesh().active_cell_iterators())
    if (cell->is_locally_owned()) {
      for (unsigned int c = 0; c < 2; ++c)
        for (unsigned int a = 0; a < layout.n_nodes(c); ++a)
          unknowns[layout.index(c, a)] = domain.mapping().transform_unit_to_real_cell(
              cell, layout.element(c).get_unit_support_points()[a])[c];
      for (unsigned int a = 0; a < layout.n_nodes(2); ++a)
        unknowns[layout.index(2, a)] = 2 * layout.unit(2)[a];
      values.reinit(cell);
      shapes.reinit(cell);
      for (const unsigned int q : values.quadrature_point_indices()) {
        point.reinit(values, q, unknowns);
        for (unsigned int c = 0; c < 3; ++c) {
          dealii::Tensor<1, dim> gradient;
          if (c < 2)
            gradient[c] = 1;
          const double wanted = c < 2 ? values.quadrature_point(q)[c] : 2;
          error = std::max(
              {error, std::abs(point.state.value[c] - wanted), (point.state.gradient[c] - gradient).norm()});
        }
        shapes.evaluate(values.get_quadrature().point(q), at_point.data(), gradients.data());
        for (unsigned int i = 0; i < layout.n_shapes(); ++i)
          difference = std::max({difference, std::abs(at_point[i] - point.shape_values()[i]),
                                 (gradients[i] - point.shape_gradients()[i]).norm()});
      }
    }
  report("  states", error, 1e-12);
  report("  shape functions anywhere", difference, 1e-12);
}

Vector ghosted_of(const BlockSystem<2> &system, const Vector &owned)
{
  Vector ghosted = system.ghosted_vector();
  ghosted = owned;
  return ghosted;
}

/// Local refinement at the seam: affine functions pass through it, satisfy all constraints and are in
/// equilibrium.
void check_refinement(const std::string &name, const std::string &type, const std::string &more)
{
  Case of;
  of.tie = type;
  of.more_of_tie = more;
  of.temperature = "1 + x - y";
  of.salt = "2 - x + y";
  of.formula = "T + 2*salt - phase";
  of.initial = set("temperature", of.temperature) + set("salt", of.salt) + set("phase", "5 - x + y");
  of.more = set("Adaptive cycles", "1");
  SceneModel<2> scene_model(scene(of));
  Model<2> &model = scene_model.model;
  auto system = std::make_unique<BlockSystem<2>>(model);
  system->set_up(1);
  Vector x = system->owned_vector();
  set_initial_values(model, 0., x);
  std::vector<std::vector<bool>> marked;
  for (const auto &domain : model.domains) {
    marked.emplace_back(domain->mesh().n_active_cells(), false);
    for (const auto &cell : domain->mesh().active_cell_iterators())
      marked.back()[cell->active_cell_index()] =
          cell->is_locally_owned() && std::abs(cell->center()[0] - 1) < 0.5 && cell->center()[1] < 0.6;
  }
  x = model.refine(marked, ghosted_of(*system, x));
  system = std::make_unique<BlockSystem<2>>(model);
  system->set_up(1);
  Vector wanted = system->owned_vector();
  set_initial_values(model, 0., wanted);
  Vector difference = wanted;
  difference -= x;
  system->begin_step(1, wanted);
  system->assemble(wanted, false);
  double residual = 0;
  for (const auto dof : model.numbering->owned)
    if (!system->is_constrained(dof))
      residual = std::max(residual, std::abs(system->negative_residual()(dof)));
  print("refined, " + name, {double(model.numbering->n_dofs())});
  report("  transfer", difference.linfty_norm(), 1e-12);
  report("  constraints", !system->moves_constraints());
  if (name != "pointwise" &&
      name != "standard mortar") // not consistent; has multipliers that are not known here
    report("  equilibrium", residual, 1e-12);
}

/// The whole program: local refinement by estimated errors, pictures, balance; another solver.
void check_runs()
{
  Case of;
  of.temperature = "exp(2*x)*cos(2*y)";
  of.salt = "exp(2*y)*cos(2*x)";
  of.phase = "(" + of.temperature + ")*(" + of.salt + ")";
  of.reaction = "T - salt";
  of.source = of.salt + " - " + of.temperature;
  of.formula = "T*salt - phase";
  const auto coarse = errors_of<2>(of);
  of.more = set("Adaptive cycles", "2");
  const auto fine = errors_of<2>(of);
  print("errors, refined locally", {coarse[0], coarse[1], coarse[2], fine[0], fine[1], fine[2]});
  report("which decreases them", std::max({fine[0] / coarse[0], fine[1] / coarse[1], fine[2] / coarse[2]}),
         0.8);
  double imbalance = 0;
  for (const std::string domain : {"left", "right"})
    for (const std::string field : {"temperature", "salt", "phase"})
      imbalance =
          std::max(imbalance, std::abs(last_report["balance"][domain][field]["imbalance"].get<double>()));
  report("balance", imbalance, 1e-9);

  of.conductivity = "3 + 0.1*salt^2 + 0.001*phase^2"; // one system of all fields
  for (const std::string type : {"direct", "multigrid"}) {
    of.more = subsection("Linear solver", set("Type", type));
    const auto errors = errors_of<2>(of);
    print(type, {errors[0], errors[1], errors[2]});
  }
}

/// Of a system in which everything depends on everything.
void check_tangent(const std::string &name, const Case &changed)
{
  Case of = changed;
  of.conductivity = "2 + 0.3*T + 0.2*salt + 0.1*phase";
  of.diffusivity = "1 + 0.1*T + 0.2*salt^2 + 0.3*phase";
  of.reaction = "T - salt*phase";
  of.formula = "T*salt - phase^2";
  of.more += subsection("Newton", set("Maximum iterations", "20"));
  SceneModel<2> scene_model(scene(of));
  Model<2> &model = scene_model.model;
  BlockSystem<2> system(model);
  system.set_up(1.);
  Vector x = system.owned_vector();
  for (const auto dof : model.numbering->owned)
    x(dof) = 1 + 0.2 * noise(dof);
  x.compress(dealii::VectorOperation::insert);
  system.constrain(x);
  system.begin_step(1., x);
  report(name + ", defined", system.assemble(x, true));
  Vector v = system.owned_vector(), product = system.owned_vector(), y = x;
  for (const auto dof : model.numbering->owned)
    v(dof) = system.is_constrained(dof) ? 0 : noise(dof + 17);
  v.compress(dealii::VectorOperation::insert);
  system.tangent().vmult(product, v);
  const double h = 1e-6;
  y.add(h, v);
  system.constrain(y);
  system.assemble(y, false);
  Vector difference = system.negative_residual();
  y.add(-2 * h, v);
  system.constrain(y);
  system.assemble(y, false);
  difference -= system.negative_residual();
  difference *= -1 / (2 * h);
  difference -= product;
  report(name + ", tangent", difference.l2_norm() / product.l2_norm(), 1e-8);
}

void check_tangents()
{
  Case of;
  check_tangent("theta 1", of);
  of.simplices = true;
  check_tangent("triangles", of);
  of.more_of_tie = set("Theta", "0");
  check_tangent("theta 0", of);
  of.simplices = false;
  of.tie = "mortar";
  of.more_of_tie = "";
  check_tangent("mortar", of);
  of.tie = "contact resistance";
  of.more_of_tie = set("Conductance", "3 + 0.1*T") + set("Fields", "temperature");
  check_tangent("contact resistance", of);
  of.of_salt = set("Method", "Nitsche");
  check_tangent("weak values", of);
}

void check_message(const std::string &what, const std::string &prm)
{
  std::string message = "none";
  try {
    const SceneModel<2> wrong(prm);
  } catch (const UserError &error) {
    message = error.what();
  }
  if (is_rank_0())
    std::cout << what << ": " << message << std::endl;
}

void check_wrong_input()
{
  Case of;
  std::string prm = scene(of);
  const std::string field = set("Field", "salt");
  check_message("condition", std::string(prm).replace(prm.find(field), field.size(), set("Field", "phase")));
  of.more_of_tie = set("Fields", "phase");
  check_message("tie", scene(of));
  of.more_of_tie = "";
  of.degree = "1";
  check_message("degree", scene(of));
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  add_material_part<Brine>(40);
  for (const bool simplices : {false, true}) {
    check_layout<2>(simplices);
    check_layout<3>(simplices);
  }
  for (const auto &[name, type, more] : ties)
    check_refinement(name, type, more);
  check_tangents();
  check_wrong_input();
  for (const bool simplices : {false, true}) {
    check_patch<2>(simplices, "2");
    check_patch<3>(simplices, "2");
    check_rates(simplices);
  }
  check_patch<2>(false, "3");
  check_runs();
}
