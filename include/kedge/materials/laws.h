// The list of laws. A law is one header in materials/laws/, one line here and one case in the tests.
#pragma once

#include <kedge/materials/law_list.h>
#include <kedge/materials/laws/clay.h>
#include <kedge/materials/laws/drucker_prager.h>
#include <kedge/materials/laws/elastic.h>
#include <kedge/materials/laws/mohr_coulomb.h>
#include <kedge/materials/laws/von_mises.h>
#include <kedge/materials/laws/willam_warnke.h>

namespace kedge
{
using Laws = LawList<Elastic,       //
                     VonMises,      //
                     Clay,          //
                     DruckerPrager, //
                     WillamWarnke,  //
                     MohrCoulomb>;

template <typename Law> inline constexpr unsigned int law_index = Laws::index<Law>();
} // namespace kedge
