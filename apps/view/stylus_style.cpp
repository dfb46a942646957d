#include "apps/view/stylus_style.h"

#include <vtkObjectFactory.h>

namespace trephine::view {

vtkStandardNewMacro(StylusStyle);

}  // namespace trephine::view
