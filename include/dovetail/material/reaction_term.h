// SPDX-License-Identifier: LGPL-2.1-or-later
// Copyright (C) 2026 by the Dovetail authors
//
// What produces a scalar: a reaction, a source of heat.

#pragma once

#include <dovetail/material/diffusion_term.h>
#include <dovetail/scene/section.h>

#include <boost/algorithm/string/case_conv.hpp>

namespace dovetail {

/// S = -r(scalars, X, t), where the reaction r is a production per volume and time.
template <int dim>
class ReactionTerm : public Term<dim>
{
public:
  /// @param section and @p entry of the formula, for messages
  ReactionTerm(const Field &field, const std::vector<Field> &all, const Section &section,
               const std::string &entry, const Expression &reaction);

  bool has_flux() const override { return false; }
  bool has_source() const override { return true; }
  Coupling coupling(unsigned int c, unsigned int d) const override;
  bool is_linear() const override { return reaction.is_affine_in_scalars(); }
  bool is_symmetric() const override { return never_grows; }
  bool depends_on_time() const override { return reaction.depends_on_time(); }
  std::string description() const override { return boost::to_lower_copy(entry); }

  bool add(const State<dim> &state, bool with_derivatives, Response<dim> &response) const override;

private:
  const Scalars scalars;
  const Section section;
  const std::string entry;
  const Expression reaction;
  bool never_grows; ///< r does not grow with its own scalar, as far as the text shows
};

} // namespace dovetail
