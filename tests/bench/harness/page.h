// omni-bench page: puts the tables of benchmark documents into a page of Markdown, so that no figure is typed by hand.
#pragma once

#include <map>
#include <string>

#include <nlohmann/json_fwd.hpp>

#include "service/base/result.h"

namespace omni::bench {

// By name: "solver" for solver.json.
using BenchDocuments = std::map<std::string, nlohmann::ordered_json>;

// Returns `page` with the text between a line `<!-- results: NAME -->` and the next line `<!-- end -->` replaced by the
// command that made the document, its commit and machine, and the document's rows. NAME/TABLE: only those of its side
// table or section TABLE. NAME:KEY: only rows in which KEY is measured. Columns without any measurement are left out.
// Places whose document is not given are kept. Errors: a place without end, a document without a place, a table that
// its document does not have.
base::Result<std::string> FillPage(const std::string& page, const BenchDocuments& documents);

}  // namespace omni::bench
