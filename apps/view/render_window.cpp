#include "apps/view/render_window.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <algorithm>
#include <cstdlib>
#include <dlfcn.h>
#include <vtkActor2D.h>
#include <vtkBillboardTextActor3D.h>
#include <vtkCallbackCommand.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkMapper2D.h>
#include <vtkNew.h>
#include <vtkPNGWriter.h>
#include <vtkPropCollection.h>
#include <vtkRenderer.h>
#include <vtkRendererCollection.h>
#include <vtkTextActor.h>
#include <vtkTextProperty.h>
#include <vtkUnsignedCharArray.h>
#include <vtkWindowToImageFilter.h>

#include "data-tools/files/atomic_file.h"

// The headers of X define macros with common names, so they come last.
#include <X11/Xlib.h>
#undef Status
#undef None
#undef Bool
#undef Success

/// Debian's GLEW is built for GLX: without an X display it loads every OpenGL function and then fails because
/// GLX is missing (result 4). VTK interprets that as missing OpenGL, so this replacement ignores that result.
extern "C" unsigned int glewInit() {
  using Init = unsigned int (*)();
  const auto real = reinterpret_cast<Init>(dlsym(RTLD_NEXT, "glewInit"));
  constexpr unsigned int k_no_glx_display = 4;
  const unsigned int result = real ? real() : 1;
  return result == k_no_glx_display ? 0 : result;
}

namespace trephine::view {

bool has_display() {
  // Qt ends the process if it cannot connect, so a connection is tried first.
  static const bool k_can_connect = [] {
    Display* display = XOpenDisplay(nullptr);
    if (display != nullptr) XCloseDisplay(display);
    return display != nullptr;
  }();
  return k_can_connect;
}

Error no_display() {
  const char* name = std::getenv("DISPLAY");
  return Error{.what = "no display",
               .found = name == nullptr || *name == '\0'
                            ? "DISPLAY is not set"
                            : "no X server answers at DISPLAY=" + std::string(name),
               .expected = "an X display",
               .remedy = "write a picture without a display (option screenshot FILE)",
               .kind = ErrorKind::missing_here};
}

namespace {

/// A core OpenGL context of Mesa's surfaceless platform, and a VTK window that draws into its own
/// framebuffer.
class EglSurface final : public DrawSurface {
 public:
  static std::unique_ptr<EglSurface> make(int width, int height) {
    auto surface = std::unique_ptr<EglSurface>(new EglSurface);
    const auto get_display =
        reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(eglGetProcAddress("eglGetPlatformDisplayEXT"));
    if (get_display == nullptr) return nullptr;
    surface->display_ = get_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
    if (surface->display_ == EGL_NO_DISPLAY || !eglInitialize(surface->display_, nullptr, nullptr))
      return nullptr;
    eglBindAPI(EGL_OPENGL_API);
    const EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                                 3,
                                 EGL_CONTEXT_MINOR_VERSION,
                                 3,
                                 EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                 EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                 EGL_NONE};
    surface->context_ =
        eglCreateContext(surface->display_, static_cast<EGLConfig>(nullptr), EGL_NO_CONTEXT, attributes);
    if (surface->context_ == EGL_NO_CONTEXT || !surface->make_current()) return nullptr;

    vtkGenericOpenGLRenderWindow* window = surface->window_;
    vtkNew<vtkCallbackCommand> on_event;
    on_event->SetClientData(surface.get());
    on_event->SetCallback([](vtkObject*, unsigned long event, void* self, void* data) {
      auto* egl = static_cast<EglSurface*>(self);
      if (event == vtkCommand::WindowMakeCurrentEvent) egl->make_current();
      if (event == vtkCommand::WindowIsCurrentEvent)
        *static_cast<bool*>(data) = eglGetCurrentContext() == egl->context_;
    });
    window->AddObserver(vtkCommand::WindowMakeCurrentEvent, on_event);
    window->AddObserver(vtkCommand::WindowIsCurrentEvent, on_event);
    window->SetIsDirect(1);
    window->SetSupportsOpenGL(1);
    window->SetReadyForRendering(true);
    window->SetMapped(true);
    window->SetSize(width, height);
    window->SetMultiSamples(8);
    window->OpenGLInit();
    return surface;
  }
  ~EglSurface() override {
    if (context_ == EGL_NO_CONTEXT) return;
    make_current();
    window_->Finalize();
    eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
    eglDestroyContext(display_, context_);
  }
  vtkRenderWindow* window() override { return window_; }

 private:
  bool make_current() {
    return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }

  EGLDisplay display_ = EGL_NO_DISPLAY;
  EGLContext context_ = EGL_NO_CONTEXT;
  vtkNew<vtkGenericOpenGLRenderWindow> window_;
};

}  // namespace

Result<std::unique_ptr<DrawSurface>> make_offscreen(int width, int height) {
  if (auto surface = EglSurface::make(width, height))
    return Result<std::unique_ptr<DrawSurface>>(std::unique_ptr<DrawSurface>(std::move(surface)));
  return Error{.what = "this machine cannot draw pictures",
               .found = "no OpenGL without a display",
               .expected = "Mesa's surfaceless EGL",
               .remedy = "install it: apt-get install libegl1 libgl1-mesa-dri",
               .kind = ErrorKind::missing_here};
}

Result<std::string> describe_gl() {
  auto surface = make_offscreen(16, 16);
  if (!surface) return surface.error();
  const std::string report = surface.value()->window()->ReportCapabilities();
  const auto value_of = [&report](const std::string& key) {
    const std::size_t at = report.find(key);
    if (at == std::string::npos) return std::string("unknown");
    const std::size_t start = report.find_first_not_of(' ', at + key.size());
    return report.substr(start, report.find('\n', start) - start);
  };
  return value_of("OpenGL renderer string:") + ", OpenGL " + value_of("OpenGL version string:");
}

namespace {

/// Returns all texts in the picture, one per line.
std::string drawn_text(vtkRenderWindow* window) {
  std::string lines;
  vtkRendererCollection* renderers = window->GetRenderers();
  renderers->InitTraversal();
  while (vtkRenderer* renderer = renderers->GetNextItem()) {
    vtkPropCollection* props = renderer->GetViewProps();
    props->InitTraversal();
    while (vtkProp* prop = props->GetNextProp()) {
      const char* text = nullptr;
      if (auto* flat = vtkTextActor::SafeDownCast(prop)) text = flat->GetInput();
      if (auto* billboard = vtkBillboardTextActor3D::SafeDownCast(prop)) text = billboard->GetInput();
      if (text && *text && prop->GetVisibility()) lines.append(text).append(1, '\n');
    }
  }
  return lines;
}

}  // namespace

std::string png_of(vtkRenderWindow* window) {
  vtkNew<vtkWindowToImageFilter> grab;
  grab->SetInput(window);
  grab->ReadFrontBufferOff();
  vtkNew<vtkPNGWriter> writer;
  writer->SetInputConnection(grab->GetOutputPort());
  writer->WriteToMemoryOn();
  if (const std::string text = drawn_text(window); !text.empty())
    writer->AddText("Description", text.c_str());
  writer->Write();
  vtkUnsignedCharArray* bytes = writer->GetResult();
  return {reinterpret_cast<const char*>(bytes->GetPointer(0)),
          static_cast<std::size_t>(bytes->GetNumberOfValues())};
}

Status write_png(vtkRenderWindow* window, const std::string& path) {
  return data_tools::write_file_atomically(path, png_of(window));
}

std::uint64_t newest_change(vtkRenderWindow* window, const vtkRenderer* except) {
  vtkMTimeType newest = 0;
  const auto add = [&](vtkObject* object) {
    if (object != nullptr) newest = std::max(newest, object->GetMTime());
  };
  vtkCollectionSimpleIterator renderers;
  window->GetRenderers()->InitTraversal(renderers);
  while (vtkRenderer* renderer = window->GetRenderers()->GetNextRenderer(renderers)) {
    if (renderer == except) continue;
    add(renderer->GetViewProps());
    vtkCollectionSimpleIterator props;
    renderer->GetViewProps()->InitTraversal(props);
    while (vtkProp* prop = renderer->GetViewProps()->GetNextProp(props)) {
      add(prop);
      if (!prop->GetVisibility()) continue;
      newest = std::max(newest, prop->GetRedrawMTime());
      if (auto* flat = vtkActor2D::SafeDownCast(prop); flat && flat->GetMapper()) {
        add(flat->GetMapper());
        add(flat->GetMapper()->GetInputDataObject(0, 0));
      }
      if (auto* text = vtkTextActor::SafeDownCast(prop)) add(text->GetTextProperty());
    }
  }
  return newest;
}

}  // namespace trephine::view
