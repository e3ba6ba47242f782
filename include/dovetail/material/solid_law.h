// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// Laws of solids at one point, always in three dimensions: SolidTerm embeds plane strain (H_33 = 0).

#pragma once

#include <dovetail/material/memory.h>
#include <dovetail/scene/section.h>

#include <deal.II/base/point.h>
#include <deal.II/base/tensor.h>

#include <array>
#include <optional>
#include <string>
#include <vector>

namespace dovetail {

class Volumetric;

/// The first Piola-Kirchhoff stress P(F, e) of a solid, F = I + H in material coordinates and e = alpha (T -
/// T0) the free thermal strain [-]. A law gets the displacement gradient H = grad u itself: F would round it
/// at 1e-16 whatever its size, and P at 1e-16 of the modulus, which is all of it under a small load. Knows no
/// mesh, no dofs, no temperature.
class SolidLaw
{
public:
  virtual ~SolidLaw() = default;

  /// What is given at the point besides H and e.
  struct Place
  {
    /// What the law remembers there. It reads the accepted variables and writes the trial ones.
    Memory memory;
    dealii::Point<3> X; ///< in material coordinates, for formulas
    double t = 0;
    double T = 0; ///< where a formula depends on the temperature (thermal_law.h)
    /// That of the stress by T, at the same H and e, is asked for in its place: coefficients are their
    /// derivatives of this order (coefficient.h).
    unsigned int derivative = 0;
  };

  struct Response : Place
  {
    dealii::Tensor<2, 3> P;     ///< first Piola-Kirchhoff stress [Pa]
    dealii::Tensor<4, 3> dP_dF; ///< [i][J][k][L] = dP_iJ/dF_kL, filled only if derivatives are asked for
    dealii::Tensor<2, 3> dP_de; ///< derivative by the thermal strain, likewise
    bool needs_dP_de = true;    ///< else a law may leave it out
  };

  /// Second derivatives of the scalar w:P(F, e), which the exact tangent of Nitsche's method needs for theta
  /// != 0.
  struct Curvature
  {
    dealii::Tensor<4, 3> FF; ///< d²(w:P)/dF_iJ dF_kL
    dealii::Tensor<2, 3> Fe; ///< d²(w:P)/dF_iJ de
    double ee = 0;
  };

  /// The rounding of P must shrink with H and e. @return false if the stress is not defined at this state (J
  /// <= 0), with the reason left as scene/undefined.h says: the step is cut, nothing crashes.
  virtual bool evaluate(const dealii::Tensor<2, 3> &H, double e, bool with_derivatives,
                        Response &response) const = 0;
  /// @pre has_curvature()
  virtual Curvature curvature(const dealii::Tensor<2, 3> & /*H*/, double /*e*/,
                              const dealii::Tensor<2, 3> & /*w*/, const Place & /*place*/) const
  {
    AssertThrow(false, dealii::ExcNotImplemented());
    return {};
  }

  /// All of grad u where the law itself finds a part of it (plane stress); nothing if it is not defined.
  virtual std::optional<dealii::Tensor<2, 3>> full_gradient(const dealii::Tensor<2, 3> &H, double /*e*/,
                                                            const Place & /*place*/) const
  {
    return H;
  }

  /// The elastic energy per undeformed volume [J/m^3]: what the stress does on the straight way from the free
  /// body, F = (1 + e) I, to the stretch U of F = R U, or of small displacements to U = I + sym H,
  /// @f[ W = \int_0^1 P(eI + sD, e) : D \,\mathrm ds, \qquad D = U - (1 + e) I. @f]
  /// NaN where the law is not defined, and of a law that remembers unless it overrides this: its work is not
  /// stored as a whole.
  virtual double energy(const dealii::Tensor<2, 3> &H, double e, const Place &place) const;

  /// What it remembers at a point; nothing if the stress is a function of the present state.
  virtual std::vector<InternalVariable> internal_variables() const { return {}; }
  /// As Term::pass().
  virtual void pass(const Place & /*place*/) const {}
  /// Whether the second derivatives exist. A law with memory has different branches, so it has none.
  virtual bool has_curvature() const { return internal_variables().empty(); }
  /// mu [Pa] of a law that flows without change of volume: at small displacements by its first 9 internal
  /// variables, at large ones along the trial stress, by its last one, the equivalent strain. Else nothing.
  virtual std::optional<double> shear_of_flow() const { return {}; }
  /// What a step adds to the derivative of the free energy by the thermal strain, at that strain: the entropy
  /// that a body gives up while it is compressed, and its own derivatives.
  struct ExpansionWork
  {
    double value = 0, by_e = 0; ///< [Pa]
    dealii::Tensor<2, 3> by_F;
  };
  /// Whether expansion_work() knows the derivatives.
  virtual bool has_expansion_work() const { return is_linear() || has_curvature(); }
  /// P_e : (H - H_n) with the gradient H_n of the last good step; P_e is constant in laws without curvature,
  /// unless they override this. @return false where the law is not defined. @pre has_expansion_work()
  virtual bool expansion_work(const dealii::Tensor<2, 3> &H, double e, const dealii::Tensor<2, 3> &H_n,
                              const Place &place, ExpansionWork &work) const;
  /// dP/dF is, and it is not negative at rest: there is an energy, or an incremental one.
  virtual bool is_symmetric() const { return true; }

  /// The part kappa U(J) of its energy if that stands by itself, so that `Formulation = mixed` may leave it
  /// to a field of pressure: then P is without it. nullptr: it does not.
  virtual const Volumetric *volume() const { return nullptr; }

  /// P is affine in (F, e): one solve, no curvature.
  virtual bool is_linear() const { return false; }
  /// P = D H at e = 0, with the same D at every place: then it need not be evaluated there.
  virtual bool is_uniform() const { return false; }
  /// It knows the deformed body: P is force per undeformed area, a pressure follows the boundary. Else (small
  /// displacements) P is the Cauchy stress itself.
  virtual bool has_large_strain() const { return !is_linear(); }
  virtual bool depends_on_time() const; ///< through t itself

  /// An entry that is a formula, and the values it may have.
  struct Range
  {
    double least, most; ///< both included
    std::string words;  ///< "must be positive"
  };
  struct Formula
  {
    Section section;
    std::string entry;
    Expression value;
    bool depends_on_temperature; ///< its only scalar, unless the range is not asked for
    std::optional<Range> range;
  };
  void add_formula(const Formula &formula) { all_formulas.push_back(formula); }
  const std::vector<Formula> &formulas() const { return all_formulas; }

private:
  std::vector<Formula> all_formulas;
};

/// Isotropic moduli: either Young modulus and Poisson ratio or Shear modulus and Bulk modulus, never a
/// mixture.
struct IsotropicModuli
{
  explicit IsotropicModuli(const Section &section);
  IsotropicModuli(const double shear, const double bulk, const bool is_mixed)
      : shear(shear), bulk(bulk), is_mixed(is_mixed)
  {
  }
  /// The entries of the pair that the scene gives, the first one positive.
  static std::array<std::string, 2> entries(const Section &section);
  double shear; ///< mu [Pa]
  double bulk;  ///< kappa [Pa], three-dimensional; infinite: the volume does not change (mixed only)
  double bulk_of_stress() const { return is_mixed ? 0 : bulk; } ///< what a field of pressure does not take
  double lame() const { return bulk_of_stress() - 2. / 3. * shear; }
  double energy_of(const dealii::Tensor<2, 3> &stress) const; ///< elastic, of small displacements [J/m^3]

private:
  bool is_mixed;
};

/// The entry `Bulk modulus`; with `Formulation = mixed` it may be inf: the volume is kept.
double read_bulk_modulus(const Section &solid, const std::string &description);

/// Whether the volume has a field of its own: the entry `Formulation`.
bool is_mixed(const Section &solid);

} // namespace dovetail
