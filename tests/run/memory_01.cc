// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// A small law with memory: a solid that becomes softer by the largest strain that it has had. Two bodies of
// it, tied with theta = 1, whose variation is frozen for it. Between smooth rigid walls the strain is
// uniform, so that memory and force are known: after loading and unloading, and at the last good step of a
// run of which the last one fails. Under an uneven load: after refinement, and against a mortar. The tangent
// against differences. The same numbers on any number of ranks.
//
// ranks: 1, 2, 3

#include "../system/scene_model.h"

#include <dovetail/material/solid_law.h>
#include <dovetail/run/simulation.h>
#include <dovetail/scene/undefined.h>

#include <fstream>

using namespace test;
using dealii::Tensor;

/// P = (1 - d) S, S = C E the elastic stress, with d = 1/2 (1 - exp(-kappa/kappa_0)), where kappa is the
/// largest value so far of (E : C E / mu)^(1/2). Not defined beyond a limit.
class Softening : public SolidLaw
{
public:
  explicit Softening(const Section &section)
      : moduli(section), scale(section.require<double>("Scale", "Of the softening [-]")),
        limit(section.read<double>("Limit", 1., "Largest strain [-]"))
  {
  }

  std::vector<InternalVariable> internal_variables() const override { return {{"largest strain"}}; }

  bool evaluate(const Tensor<2, 3> &H, double, bool with_derivatives, Response &response) const override
  {
    const Tensor<2, 3> E = 0.5 * (H + transpose(H)), I = dealii::unit_symmetric_tensor<3>();
    const Tensor<2, 3> S = moduli.lame() * trace(E) * I + 2 * moduli.shear * E;
    const double strain = std::sqrt(scalar_product(E, S) / moduli.shear);
    if (strain > limit)
      return undefined("the strain is too large");
    const double before = response.memory.accepted[0], kappa = std::max(before, strain);
    const double softness = 0.5 * (1 - std::exp(-kappa / scale)),
                 change = 0.5 / scale * std::exp(-kappa / scale);
    response.memory.trial[0] = kappa;
    response.P = (1 - softness) * S;
    if (!with_derivatives)
      return true;
    const bool grows = strain > before * (1 + 1e-10); // not by the rounding of the last good state
    for (unsigned int i = 0; i < 3; ++i)
      for (unsigned int J = 0; J < 3; ++J) {
        response.dP_dF[i][J] = moduli.lame() * I[i][J] * I;
        response.dP_dF[i][J][i][J] += moduli.shear;
        response.dP_dF[i][J][J][i] += moduli.shear;
        response.dP_dF[i][J] *= 1 - softness;
        if (grows)
          response.dP_dF[i][J] -= change / (moduli.shear * kappa) * S[i][J] * S;
      }
    response.dP_de = 0;
    return true;
  }

private:
  const IsotropicModuli moduli;
  const double scale, limit;
};

const double largest = 0.01, scale_of_law = 0.01, young = 3, poisson = 0.2, mu = young / (2 * (1 + poisson)),
             lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson));
const double factor = std::sqrt((lame + 2 * mu) / mu); ///< of kappa, for a strain in one direction

std::string condition(const std::string &name, const std::string &id, const std::string &components,
                      const std::string &value)
{
  return subsection("Boundary condition " + name,
                    set("Type", "value") + set("Field", "displacement") + set("Boundary ids", id) +
                        set("Components", components) + set("Expression", value));
}

/// @param pull what the right end does
std::string scene(const std::string &pull, const std::string &steps, const std::string &tie,
                  const std::string &more = "", const std::string &limit = "1")
{
  std::string probes;
  for (const std::string domain : {"left", "right"})
    for (const std::string reduce : {"minimum", "maximum"})
      probes +=
          subsection("Probe " + domain + " " + reduce,
                     set("Domain", domain) + set("Quantity", "internal variables") + set("Reduce", reduce));
  std::ostringstream law;
  law << set("Type", "softening") << set("Young modulus", std::to_string(young))
      << set("Poisson ratio", std::to_string(poisson)) << set("Scale", std::to_string(scale_of_law))
      << set("Limit", limit);
  return set("Dimension", "2") + set("Materials", "soft") + set("Domains", "left, right") +
         set("Interfaces", "seam") +
         set("Probes", "left minimum, left maximum, right minimum, right maximum, force") +
         subsection("Material soft", subsection("Solid", law.str())) +
         subsection("Domain left", set("Material", "soft") + set("Boundary conditions", "wall, sides") +
                                       condition("wall", "0", "x", "0") +
                                       condition("sides", "2, 3", "y", "0") + box("2, 3 : 0, 0 : 1, 1")) +
         subsection("Domain right", set("Material", "soft") + set("Degree", "2") +
                                        set("Boundary conditions", "pull, sides") +
                                        condition("pull", "1", "x", pull) +
                                        condition("sides", "2, 3", "y", "0") + box("3, 2 : 1, 0 : 2, 1")) +
         subsection("Interface seam", set("Source", "left : 1") + set("Destination", "right : 0") + tie) +
         probes + subsection("Probe force", set("Boundary", "right : 1") + set("Field", "displacement")) +
         subsection("Steps", steps) +
         subsection("Output", set("Paraview", "false") + set("Directory", "out")) + more;
}

struct Outcome
{
  nlohmann::json report;
  bool is_converged;
  double probe(const std::string &name) const { return report["probes"][name]; }
  double force() const { return report["probes"]["force"][0]; }
};

Outcome run(const std::string &prm)
{
  std::ofstream nowhere;
  auto *const terminal = std::cout.rdbuf(nowhere.rdbuf());
  Outcome outcome;
  {
    Simulation<2> simulation(SceneText::from_prm(prm), MPI_COMM_WORLD);
    outcome.is_converged = simulation.run();
  }
  std::cout.rdbuf(terminal);
  std::ifstream("out/report.json") >> outcome.report;
  MPI_Barrier(MPI_COMM_WORLD);
  return outcome;
}

/// All probes of the largest strain so far, and the force at a strain.
double error_of(const Outcome &outcome, const double largest_strain, const double strain)
{
  const double kappa = factor * largest_strain;
  double error = 0;
  for (const std::string probe : {"left minimum", "left maximum", "right minimum", "right maximum"})
    error = std::max(error, std::abs(outcome.probe(probe) / kappa - 1));
  const double force = (1 - 0.5 * (1 - std::exp(-kappa / scale_of_law))) * (lame + 2 * mu) * strain;
  return std::max(error, std::abs(outcome.force() / force - 1));
}

void check_uniform()
{
  const std::string nitsche = set("Type", "Nitsche");
  const std::string cycle = "0.02*(if(t < 0.5, 2*t, 1.6 - 1.2*t))"; // 0.02 at 0.5, 0.008 at the end
  for (const std::string theta : {"1", "-1", "0"}) {
    const Outcome outcome = run(scene(cycle, set("Number of steps", "4"), nitsche + set("Theta", theta)));
    report("theta " + theta + ": loaded and unloaded",
           outcome.is_converged ? error_of(outcome, 0.01, 0.004) : 1, 1e-9);
  }
  std::string weak = scene(cycle, set("Number of steps", "4"), nitsche);
  const std::string pull = "subsection Boundary condition pull\n";
  weak.insert(weak.find(pull) + pull.size(), set("Method", "Nitsche"));
  const Outcome prescribed_weakly = run(weak);
  report("pulled by a weak value",
         prescribed_weakly.is_converged ? error_of(prescribed_weakly, 0.01, 0.004) : 1, 1e-9);
  const Outcome failed =
      run(scene("0.02*t", set("Number of steps", "4"), nitsche, "", std::to_string(factor * 0.01 * 0.815)));
  const double t = failed.report["steps"].back()["time"], good = failed.report["probes"]["right maximum"];
  report("the last step fails", !failed.is_converged && t > 0.8125);
  const double strain = good / factor;
  report("what is remembered is that of the last good one", error_of(failed, strain, strain), 1e-9);
  report("which was near the limit", std::abs(strain / 0.00815 - 1), 2e-3);
}

void check_uneven()
{
  const std::string steps = set("Number of steps", "4"), cycles = set("Adaptive cycles", "2");
  const std::string cycle = "0.02*(if(t < 0.5, 2*t, 1.6 - 1.2*t))*(1 + y)";
  const Outcome coarse = run(scene(cycle, steps, set("Type", "Nitsche"))),
                fine = run(cycles + scene(cycle, steps, set("Type", "Nitsche"))),
                mortar = run(cycles + scene(cycle, steps, set("Type", "mortar")));
  report("all converge", coarse.is_converged && fine.is_converged && mortar.is_converged);
  report("refinement refines", fine.report["dofs"] > coarse.report["dofs"]);
  print("coarse", {coarse.probe("left maximum") / 0.01, coarse.probe("right maximum") / 0.01,
                   coarse.probe("left minimum") / 0.01, coarse.force() / 0.01});
  print("refined", {fine.probe("left maximum") / 0.01, fine.probe("right maximum") / 0.01,
                    fine.probe("left minimum") / 0.01, fine.force() / 0.01});
  report("refinement keeps the memory",
         std::abs(fine.probe("left maximum") / coarse.probe("left maximum") - 1), 0.1);
  report("and the force", std::abs(fine.force() / coarse.force() - 1), 0.02);
  report("as a mortar has it", std::abs(fine.force() / mortar.force() - 1), 0.005);
}

void check_tangent()
{
  SceneModel<2> scene_model(scene("0", "", set("Type", "Nitsche")).substr(set("Dimension", "2").size()));
  Model<2> &model = scene_model.model;
  BlockSystem<2> system(model);
  system.set_up(1.);
  const auto wave = [&](const double size, Vector &x) {
    interpolate<2>(
        model,
        [=](const unsigned int d, const unsigned int c, const dealii::Point<2> &X) {
          return size * std::sin(5 * X[0] + 3 * X[1] + c + d);
        },
        x);
    system.constrain(x);
  };
  Vector x = system.owned_vector();
  wave(1e-3, x);
  system.begin_step(1., x);
  report("it remembers", system.remember(1., x));
  system.begin_step(1., x);
  for (const double size : {2e-3, 5e-4}) { // loading, unloading
    wave(size, x);
    report("defined", system.assemble(x, true));
    Vector v = system.owned_vector(), product = system.owned_vector(), y = x;
    for (const auto dof : model.numbering->owned)
      v(dof) = system.is_constrained(dof) ? 0 : noise(dof);
    v.compress(dealii::VectorOperation::insert);
    system.tangent().vmult(product, v);
    const double h = 1e-8;
    y.add(h, v);
    system.assemble(y, false);
    Vector difference = system.negative_residual();
    y.add(-2 * h, v);
    system.assemble(y, false);
    difference -= system.negative_residual();
    difference *= -1 / (2 * h);
    difference -= product;
    report("tangent", difference.l2_norm() / product.l2_norm(), 1e-6);
  }
}

int main(int argc, char **argv)
{
  dealii::Utilities::MPI::MPI_InitFinalize mpi(argc, argv, 1);
  Catalogue<SolidLaw>::add<Softening>("softening", "For this test.");
  check_tangent();
  check_uniform();
  check_uneven();
}
