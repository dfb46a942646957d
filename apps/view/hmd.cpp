#include "apps/view/hmd.h"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>
#include <string>
#include <utility>
#include <vector>
#include <vtk_glew.h>

#include "apps/view/framebuffer_copy.h"
#include "apps/workbench/text.h"

// The headers of X define macros with common names, so they come last.
#include <GL/glx.h>
#undef Status
#undef None
#undef Bool
#undef Success
#define XR_NO_PROTOTYPES
#define XR_USE_PLATFORM_XLIB
#define XR_USE_GRAPHICS_API_OPENGL
#include <openxr/openxr.h>
#include <openxr/openxr_platform.h>

namespace trephine::view {

namespace {

using workbench::format_text;

constexpr const char* k_loader = "libopenxr_loader.so.1";
constexpr double k_mm = 1000;  // mm per m

/// Returns a structure of OpenXR with its type; other members are zero.
template <class Structure>
Structure structure(XrStructureType type) {
  Structure result{};
  result.type = type;
  return result;
}

Error no_hmd(const char* what, std::string found, const char* remedy) {
  return {.what = what,
          .where = "head-mounted display",
          .found = std::move(found),
          .remedy = remedy,
          .kind = ErrorKind::missing_here};
}

/// Functions of the loader that are used. The runtime provides them by name.
struct Functions {
  PFN_xrGetInstanceProcAddr get = nullptr;
  PFN_xrCreateInstance create_instance = nullptr;
  PFN_xrDestroyInstance destroy_instance = nullptr;
  PFN_xrGetSystem get_system = nullptr;
  PFN_xrEnumerateViewConfigurationViews views = nullptr;
  PFN_xrGetOpenGLGraphicsRequirementsKHR requirements = nullptr;
  PFN_xrCreateSession create_session = nullptr;
  PFN_xrDestroySession destroy_session = nullptr;
  PFN_xrCreateReferenceSpace create_space = nullptr;
  PFN_xrEnumerateSwapchainFormats formats = nullptr;
  PFN_xrCreateSwapchain create_swapchain = nullptr;
  PFN_xrEnumerateSwapchainImages images = nullptr;
  PFN_xrPollEvent poll_event = nullptr;
  PFN_xrBeginSession begin_session = nullptr;
  PFN_xrEndSession end_session = nullptr;
  PFN_xrWaitFrame wait_frame = nullptr;
  PFN_xrBeginFrame begin_frame = nullptr;
  PFN_xrEndFrame end_frame = nullptr;
  PFN_xrLocateViews locate_views = nullptr;
  PFN_xrAcquireSwapchainImage acquire = nullptr;
  PFN_xrWaitSwapchainImage wait_image = nullptr;
  PFN_xrReleaseSwapchainImage release = nullptr;
};

class OpenXr final : public Hmd {
 public:
  OpenXr() = default;
  OpenXr(const OpenXr&) = delete;
  OpenXr& operator=(const OpenXr&) = delete;
  ~OpenXr() override {
    if (session_ != XR_NULL_HANDLE) xr_.destroy_session(session_);
    if (instance_ != XR_NULL_HANDLE) xr_.destroy_instance(instance_);
    if (library_ != nullptr) dlclose(library_);
  }

  Status open();
  std::optional<std::array<HmdEye, 2>> begin_frame() override;
  void show(int eye, unsigned framebuffer, int width, int height) override;
  void end_frame() override;
  void end_session() override;
  Status problem() const override { return problem_; }

 private:
  template <class Function>
  bool find(Function& function, const char* name) {
    return XR_SUCCEEDED(xr_.get(instance_, name, reinterpret_cast<PFN_xrVoidFunction*>(&function)));
  }
  bool find_functions();
  void start_session();
  void make_swapchains();
  void handle_events();
  /// Records a failed call as the reason why the display ended. Returns true if the call succeeded.
  bool check(XrResult result, const char* call) {
    if (XR_SUCCEEDED(result)) return true;
    if (!problem_)
      problem_ = no_hmd("the head-mounted display ended",
                        format_text("%s returned %d", call, static_cast<int>(result)),
                        "check the display and its software, then open the window again");
    return false;
  }

  void* library_ = nullptr;
  Functions xr_;
  XrInstance instance_ = XR_NULL_HANDLE;
  XrSystemId system_ = XR_NULL_SYSTEM_ID;
  XrSession session_ = XR_NULL_HANDLE;
  XrSpace room_ = XR_NULL_HANDLE;
  struct Picture {
    XrSwapchain swapchain = XR_NULL_HANDLE;
    int width = 0, height = 0;
    std::vector<XrSwapchainImageOpenGLKHR> images;
  };
  std::array<Picture, 2> pictures_;
  std::array<XrView, 2> located_{structure<XrView>(XR_TYPE_VIEW), structure<XrView>(XR_TYPE_VIEW)};
  XrTime display_time_ = 0;
  unsigned copy_ = 0;  ///< framebuffer to which images of the display are attached
  bool is_running_ = false;
  std::array<bool, 2> shown_{};  ///< the eyes received a picture in this frame
  Status problem_;
};

bool OpenXr::find_functions() {
  return find(xr_.destroy_instance, "xrDestroyInstance") && find(xr_.get_system, "xrGetSystem") &&
         find(xr_.views, "xrEnumerateViewConfigurationViews") &&
         find(xr_.requirements, "xrGetOpenGLGraphicsRequirementsKHR") &&
         find(xr_.create_session, "xrCreateSession") && find(xr_.destroy_session, "xrDestroySession") &&
         find(xr_.create_space, "xrCreateReferenceSpace") &&
         find(xr_.formats, "xrEnumerateSwapchainFormats") &&
         find(xr_.create_swapchain, "xrCreateSwapchain") && find(xr_.images, "xrEnumerateSwapchainImages") &&
         find(xr_.poll_event, "xrPollEvent") && find(xr_.begin_session, "xrBeginSession") &&
         find(xr_.end_session, "xrEndSession") && find(xr_.wait_frame, "xrWaitFrame") &&
         find(xr_.begin_frame, "xrBeginFrame") && find(xr_.end_frame, "xrEndFrame") &&
         find(xr_.locate_views, "xrLocateViews") && find(xr_.acquire, "xrAcquireSwapchainImage") &&
         find(xr_.wait_image, "xrWaitSwapchainImage") && find(xr_.release, "xrReleaseSwapchainImage");
}

Status OpenXr::open() {
  const char* other = std::getenv("TREPHINE_OPENXR_LOADER");
  library_ = dlopen(other ? other : k_loader, RTLD_NOW | RTLD_LOCAL);
  if (library_ == nullptr)
    return no_hmd("the OpenXR loader is missing", dlerror(),
                  "install libopenxr-loader1, and the software of the display");
  xr_.get = reinterpret_cast<PFN_xrGetInstanceProcAddr>(dlsym(library_, "xrGetInstanceProcAddr"));
  if (xr_.get == nullptr || !find(xr_.create_instance, "xrCreateInstance"))
    return no_hmd("the OpenXR loader is damaged", "a library without xrCreateInstance",
                  "install libopenxr-loader1 again");
  const char* extensions[] = {XR_KHR_OPENGL_ENABLE_EXTENSION_NAME};
  auto info = structure<XrInstanceCreateInfo>(XR_TYPE_INSTANCE_CREATE_INFO);
  std::strncpy(info.applicationInfo.applicationName, "trephine", XR_MAX_APPLICATION_NAME_SIZE - 1);
  info.applicationInfo.apiVersion = XR_MAKE_VERSION(1, 0, 0);
  info.enabledExtensionCount = 1, info.enabledExtensionNames = extensions;
  if (const XrResult result = xr_.create_instance(&info, &instance_); !XR_SUCCEEDED(result))
    return no_hmd(result == XR_ERROR_EXTENSION_NOT_PRESENT ? "the OpenXR runtime does not support OpenGL"
                                                           : "no OpenXR runtime answers",
                  format_text("xrCreateInstance returned %d", static_cast<int>(result)),
                  "start the software of the display, and select it as the OpenXR runtime");
  if (!find_functions())
    return no_hmd("the OpenXR runtime lacks functions", "a runtime without a function of OpenXR 1.0",
                  "update the software of the display");
  auto wanted = structure<XrSystemGetInfo>(XR_TYPE_SYSTEM_GET_INFO);
  wanted.formFactor = XR_FORM_FACTOR_HEAD_MOUNTED_DISPLAY;
  if (const XrResult result = xr_.get_system(instance_, &wanted, &system_); !XR_SUCCEEDED(result))
    return no_hmd("no head-mounted display was found",
                  format_text("xrGetSystem returned %d", static_cast<int>(result)),
                  "connect the display and switch it on");
  return std::nullopt;
}

/// Creates session, room and pictures in the current GL context.
void OpenXr::start_session() {
  auto requirements = structure<XrGraphicsRequirementsOpenGLKHR>(XR_TYPE_GRAPHICS_REQUIREMENTS_OPENGL_KHR);
  if (!check(xr_.requirements(instance_, system_, &requirements), "xrGetOpenGLGraphicsRequirementsKHR"))
    return;
  Display* display = glXGetCurrentDisplay();
  const GLXContext context = glXGetCurrentContext();
  if (display == nullptr || context == nullptr) {
    problem_ = no_hmd("the head-mounted display needs a window of X11", "a window of another system",
                      "start trephine with QT_QPA_PLATFORM=xcb");
    return;
  }
  int id = 0, screen = 0, count = 0;
  glXQueryContext(display, context, GLX_FBCONFIG_ID, &id);
  glXQueryContext(display, context, GLX_SCREEN, &screen);
  const int attributes[] = {GLX_FBCONFIG_ID, id, 0};
  GLXFBConfig* configurations = glXChooseFBConfig(display, screen, attributes, &count);
  auto binding = structure<XrGraphicsBindingOpenGLXlibKHR>(XR_TYPE_GRAPHICS_BINDING_OPENGL_XLIB_KHR);
  binding.xDisplay = display;
  binding.glxContext = context;
  binding.glxDrawable = glXGetCurrentDrawable();
  if (configurations != nullptr && count > 0) {
    int visual = 0;
    glXGetFBConfigAttrib(display, configurations[0], GLX_VISUAL_ID, &visual);
    binding.visualid = static_cast<std::uint32_t>(visual);
    binding.glxFBConfig = configurations[0];
  }
  if (configurations != nullptr) XFree(configurations);
  auto info = structure<XrSessionCreateInfo>(XR_TYPE_SESSION_CREATE_INFO);
  info.next = &binding, info.systemId = system_;
  if (!check(xr_.create_session(instance_, &info, &session_), "xrCreateSession")) return;
  auto space = structure<XrReferenceSpaceCreateInfo>(XR_TYPE_REFERENCE_SPACE_CREATE_INFO);
  space.referenceSpaceType = XR_REFERENCE_SPACE_TYPE_LOCAL;
  space.poseInReferenceSpace.orientation.w = 1;
  if (check(xr_.create_space(session_, &space, &room_), "xrCreateReferenceSpace")) make_swapchains();
}

void OpenXr::end_session() {
  if (session_ != XR_NULL_HANDLE) xr_.destroy_session(session_);  // with its pictures and spaces
  if (copy_ != 0) glDeleteFramebuffers(1, &copy_);
  session_ = XR_NULL_HANDLE, room_ = XR_NULL_HANDLE;
  pictures_ = {}, copy_ = 0, is_running_ = false;
  // A runtime may allow one instance per program: a lost display frees it, so that it can be opened again
  // while others still hold this object.
  if (problem_ && instance_ != XR_NULL_HANDLE)
    xr_.destroy_instance(std::exchange(instance_, XrInstance{XR_NULL_HANDLE}));
}

void OpenXr::make_swapchains() {
  std::uint32_t count = 0;
  std::array<XrViewConfigurationView, 2> sizes;
  sizes.fill(structure<XrViewConfigurationView>(XR_TYPE_VIEW_CONFIGURATION_VIEW));
  if (!check(
          xr_.views(instance_, system_, XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO, 2, &count, sizes.data()),
          "xrEnumerateViewConfigurationViews"))
    return;
  if (!check(xr_.formats(session_, 0, &count, nullptr), "xrEnumerateSwapchainFormats")) return;
  std::vector<std::int64_t> formats(count);
  if (!check(xr_.formats(session_, count, &count, formats.data()), "xrEnumerateSwapchainFormats")) return;
  // The pictures have sRGB values. A linear format would brighten them, but all runtimes accept it.
  const bool has_srgb = std::find(formats.begin(), formats.end(), GL_SRGB8_ALPHA8) != formats.end();
  for (std::size_t eye = 0; eye < 2; ++eye) {
    Picture& picture = pictures_[eye];
    picture.width = static_cast<int>(sizes[eye].recommendedImageRectWidth);
    picture.height = static_cast<int>(sizes[eye].recommendedImageRectHeight);
    auto info = structure<XrSwapchainCreateInfo>(XR_TYPE_SWAPCHAIN_CREATE_INFO);
    info.usageFlags = XR_SWAPCHAIN_USAGE_COLOR_ATTACHMENT_BIT;
    info.format = has_srgb ? GL_SRGB8_ALPHA8 : GL_RGBA8;
    info.sampleCount = info.faceCount = info.arraySize = info.mipCount = 1;
    info.width = sizes[eye].recommendedImageRectWidth, info.height = sizes[eye].recommendedImageRectHeight;
    if (!check(xr_.create_swapchain(session_, &info, &picture.swapchain), "xrCreateSwapchain")) return;
    if (!check(xr_.images(picture.swapchain, 0, &count, nullptr), "xrEnumerateSwapchainImages")) return;
    picture.images.assign(count, structure<XrSwapchainImageOpenGLKHR>(XR_TYPE_SWAPCHAIN_IMAGE_OPENGL_KHR));
    if (!check(xr_.images(picture.swapchain, count, &count,
                          reinterpret_cast<XrSwapchainImageBaseHeader*>(picture.images.data())),
               "xrEnumerateSwapchainImages"))
      return;
  }
  glGenFramebuffers(1, &copy_);
}

/// Follows the state of the session, which the runtime changes when the display is put on or taken off.
void OpenXr::handle_events() {
  for (;;) {
    auto event = structure<XrEventDataBuffer>(XR_TYPE_EVENT_DATA_BUFFER);
    const XrResult result = xr_.poll_event(instance_, &event);
    if (result == XR_EVENT_UNAVAILABLE || !check(result, "xrPollEvent")) return;
    if (event.type == XR_TYPE_EVENT_DATA_INSTANCE_LOSS_PENDING) {
      check(XR_ERROR_INSTANCE_LOST, "the runtime");
      return;
    }
    if (event.type != XR_TYPE_EVENT_DATA_SESSION_STATE_CHANGED) continue;
    switch (reinterpret_cast<const XrEventDataSessionStateChanged&>(event).state) {
      case XR_SESSION_STATE_READY: {
        auto info = structure<XrSessionBeginInfo>(XR_TYPE_SESSION_BEGIN_INFO);
        info.primaryViewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
        is_running_ = check(xr_.begin_session(session_, &info), "xrBeginSession");
        break;
      }
      case XR_SESSION_STATE_STOPPING:
        is_running_ = false;
        check(xr_.end_session(session_), "xrEndSession");
        break;
      case XR_SESSION_STATE_EXITING:
      case XR_SESSION_STATE_LOSS_PENDING:
        is_running_ = false;
        check(XR_ERROR_SESSION_LOST, "the runtime");
        return;
      default:
        break;
    }
  }
}

std::optional<std::array<HmdEye, 2>> OpenXr::begin_frame() {
  if (problem_) return std::nullopt;
  if (session_ == XR_NULL_HANDLE) start_session();
  if (!problem_) handle_events();
  if (problem_ || !is_running_) return std::nullopt;
  auto frame = structure<XrFrameState>(XR_TYPE_FRAME_STATE);
  if (!check(xr_.wait_frame(session_, nullptr, &frame), "xrWaitFrame")) return std::nullopt;
  if (!check(xr_.begin_frame(session_, nullptr), "xrBeginFrame")) return std::nullopt;
  display_time_ = frame.predictedDisplayTime, shown_ = {};
  auto where = structure<XrViewLocateInfo>(XR_TYPE_VIEW_LOCATE_INFO);
  where.viewConfigurationType = XR_VIEW_CONFIGURATION_TYPE_PRIMARY_STEREO;
  where.displayTime = display_time_, where.space = room_;
  auto state = structure<XrViewState>(XR_TYPE_VIEW_STATE);
  std::uint32_t count = 0;
  const bool is_located =
      check(xr_.locate_views(session_, &where, &state, 2, &count, located_.data()), "xrLocateViews");
  constexpr XrViewStateFlags k_valid = XR_VIEW_STATE_POSITION_VALID_BIT | XR_VIEW_STATE_ORIENTATION_VALID_BIT;
  if (!is_located || !frame.shouldRender || count != 2 || (state.viewStateFlags & k_valid) != k_valid) {
    end_frame();
    return std::nullopt;
  }
  std::array<HmdEye, 2> eyes;
  for (std::size_t i = 0; i < 2; ++i) {
    const XrPosef& pose = located_[i].pose;
    const XrFovf& fov = located_[i].fov;
    eyes[i].position = k_mm * glm::dvec3(pose.position.x, pose.position.y, pose.position.z);
    eyes[i].orientation = glm::normalize(
        glm::dquat(pose.orientation.w, pose.orientation.x, pose.orientation.y, pose.orientation.z));
    eyes[i].left = std::tan(fov.angleLeft), eyes[i].right = std::tan(fov.angleRight);
    eyes[i].down = std::tan(fov.angleDown), eyes[i].up = std::tan(fov.angleUp);
  }
  return eyes;
}

void OpenXr::show(int eye, unsigned framebuffer, int width, int height) {
  const Picture& picture = pictures_[static_cast<std::size_t>(eye)];
  std::uint32_t index = 0;
  if (!check(xr_.acquire(picture.swapchain, nullptr, &index), "xrAcquireSwapchainImage")) return;
  auto wait = structure<XrSwapchainImageWaitInfo>(XR_TYPE_SWAPCHAIN_IMAGE_WAIT_INFO);
  wait.timeout = XR_INFINITE_DURATION;
  if (!check(xr_.wait_image(picture.swapchain, &wait), "xrWaitSwapchainImage")) return;
  GLint draw = 0;
  glGetIntegerv(GL_DRAW_FRAMEBUFFER_BINDING, &draw);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, copy_);
  glFramebufferTexture2D(GL_DRAW_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_TEXTURE_2D,
                         picture.images[index].image, 0);
  glBindFramebuffer(GL_DRAW_FRAMEBUFFER, static_cast<GLuint>(draw));
  copy_framebuffer(framebuffer, {width, height}, copy_, {picture.width, picture.height}, false);
  shown_[static_cast<std::size_t>(eye)] =
      check(xr_.release(picture.swapchain, nullptr), "xrReleaseSwapchainImage");
}

void OpenXr::end_frame() {
  std::array<XrCompositionLayerProjectionView, 2> views;
  for (std::size_t i = 0; i < 2; ++i) {
    views[i] = structure<XrCompositionLayerProjectionView>(XR_TYPE_COMPOSITION_LAYER_PROJECTION_VIEW);
    views[i].pose = located_[i].pose, views[i].fov = located_[i].fov;
    views[i].subImage.swapchain = pictures_[i].swapchain;
    views[i].subImage.imageRect.extent = {pictures_[i].width, pictures_[i].height};
  }
  auto layer = structure<XrCompositionLayerProjection>(XR_TYPE_COMPOSITION_LAYER_PROJECTION);
  layer.space = room_, layer.viewCount = 2, layer.views = views.data();
  const XrCompositionLayerBaseHeader* layers[] = {
      reinterpret_cast<const XrCompositionLayerBaseHeader*>(&layer)};
  auto info = structure<XrFrameEndInfo>(XR_TYPE_FRAME_END_INFO);
  info.displayTime = display_time_;
  info.environmentBlendMode = XR_ENVIRONMENT_BLEND_MODE_OPAQUE;
  if (shown_[0] && shown_[1]) info.layerCount = 1, info.layers = layers;
  check(xr_.end_frame(session_, &info), "xrEndFrame");
}

}  // namespace

Result<std::unique_ptr<Hmd>> open_hmd() {
  auto hmd = std::make_unique<OpenXr>();
  if (Status error = hmd->open()) return *error;
  return std::unique_ptr<Hmd>(std::move(hmd));
}

}  // namespace trephine::view
