#pragma once

#include <functional>
#include <map>
#include <string>
#include <vector>

#include "engine/base/result.h"
#include "engine/geometry/formats/affine34.h"
#include "engine/geometry/formats/collada/xml_tree.h"

namespace tandem {

/// Where the nodes of a COLLADA scene stand, as joints of skins.
class ColladaJoints {
 public:
  using LocalOf = std::function<Affine34(const XmlElement& node)>;

  /// Notes a node of the scene and all below it. `X_MP`: placing of its parent.
  void Place(const XmlElement& node, const Affine34& X_MP, int depth, const LocalOf& local_of);

  /// Returns where the joint of a name stands: by its sid, else its id, else its name below the
  /// roots of a skeleton, else so in the whole scene. `by_id`: by its id first. The error continues
  /// the joint's name: it stands nowhere, or in several places.
  Result<Affine34> Find(const std::string& name, bool by_id,
                        const std::vector<const XmlElement*>& skeleton) const;

 private:
  struct Joint {
    Affine34 X;
    std::size_t end = 0;  // behind the last joint below it
  };
  using Names = std::multimap<std::string, std::size_t>;
  enum class Match { kNone, kOne, kSeveral };
  /// Looks a name up, below these joints only; none of them: everywhere.
  Match Look(const Names& names, const std::string& name, const std::vector<std::size_t>& below,
             Affine34& X) const;

  std::vector<Joint> joints_;  // parents before children
  Names by_sid_, by_id_, by_name_;
  std::map<const XmlElement*, std::size_t> of_element_;
};

}  // namespace tandem
