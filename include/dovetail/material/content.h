// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What a scalar stores per mass or volume, as differences between two of its values.

#pragma once

#include <dovetail/material/scalar_law.h>
#include <dovetail/scene/expression.h>

#include <limits>
#include <memory>
#include <string>
#include <vector>

namespace dovetail {

/// The content H(B; s, X, t) of the scalar B beside the other scalars s: the enthalpy of a temperature.
/// Differences of H between two values of B are functions of these values, so what a step stores the next one
/// finds again.
class Content
{
public:
  virtual ~Content() = default;

  /// H(B) - H(@p from), both at the other scalars, X and t of the state. Not finite where H is not defined.
  virtual double change(const ScalarState &state, double from) const = 0;
  virtual double capacity(const ScalarState &state) const = 0; ///< dH/dB
  /// d(change)/ds by another scalar s than B.
  virtual double slope_of_change(const ScalarState &state, double from, unsigned int s) const = 0;

  virtual bool is_linear() const = 0;                       ///< the capacity depends on no scalar
  virtual bool depends_on_scalar(unsigned int s) const = 0; ///< another one than B
  virtual bool depends_on_time() const = 0;
  virtual bool depends_on_position() const = 0;
  /// Around the state H does not change at all, which no content does: its table does not reach so far.
  virtual bool is_flat(const ScalarState & /*state*/) const { return false; }
  /// NaN if it has no phases.
  virtual double liquid_fraction(const ScalarState & /*state*/) const
  {
    return std::numeric_limits<double>::quiet_NaN();
  }

  virtual std::string words_for_capacity() const { return "is "; } ///< before its number, in messages
  const std::string &entry() const { return name_of_entry; }       ///< of the section, for messages

protected:
  explicit Content(const std::string &entry) : name_of_entry(entry) {}

private:
  const std::string name_of_entry;
};

using Contents = std::vector<std::unique_ptr<const Content>>;

/// Of the capacity c = dH/dB, a formula: its integral. @param depends_on_others scalars than B
std::unique_ptr<const Content> content_of_capacity(const std::string &entry, const Expression &capacity,
                                                   bool depends_on_others);
/// Of the formula H(B, X) itself.
std::unique_ptr<const Content> content_of_formula(const std::string &entry, const Expression &content);
/// Reads the entries of the heat of melting; nothing if there is none.
std::unique_ptr<const Content> read_latent_heat(const Section &section);

} // namespace dovetail
