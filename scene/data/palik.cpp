// Optical constants of further metals and of other absorbing solids, thinned out to about one value per 20 nm. From: E.
// D. Palik (ed.), "Handbook of Optical Constants of Solids" (Academic Press, volumes I to III, 1985-1998), as the
// tables of that work are distributed by Windt's IMD and luxpop.com. Where a table ends in the visible, its last value
// goes on.
#include "scene/data/palik.h"

namespace sheaf {

namespace {

/// Amorphous carbon.
constexpr MetalSample kAmorphousCarbon[] = {{344.4f, 1.94f, 0.92f}, {364.6f, 2.0f, 0.92f},  {387.4f, 2.06f, 0.91f},
                                            {413.3f, 2.11f, 0.9f},  {442.8f, 2.17f, 0.89f}, {476.8f, 2.24f, 0.88f},
                                            {516.6f, 2.3f, 0.87f},  {563.5f, 2.38f, 0.82f}, {619.9f, 2.43f, 0.75f},
                                            {688.8f, 2.43f, 0.7f},  {774.9f, 2.33f, 0.71f}, {885.6f, 2.24f, 0.8f}};
/// Aluminium arsenide.
constexpr MetalSample kAluminiumArsenide[] = {
    {354.2f, 4.48f, 0.334f},    {375.7f, 4.13f, 0.139f},    {442.8f, 3.703f, 0.00161f},  {459.2f, 3.57f, 0.00156f},
    {476.8f, 3.472f, 0.00153f}, {495.9f, 3.394f, 0.00125f}, {516.6f, 3.329f, 0.000682f}, {539.0f, 3.273f, 0.000275f},
    {563.5f, 3.225f, 4e-05f},   {590.4f, 3.183f, 2e-06f},   {619.9f, 3.145f, 0.0f},      {652.5f, 3.112f, 0.0f},
    {688.8f, 3.082f, 0.0f},     {729.3f, 3.056f, 0.0f},     {774.9f, 3.032f, 0.0f},      {826.5f, 3.01f, 0.0f},
    {885.6f, 2.99f, 0.0f}};
/// Aluminium antimonide.
constexpr MetalSample kAluminiumAntimonide[] = {
    {354.2f, 3.95f, 2.69f}, {375.7f, 4.14f, 2.69f}, {399.9f, 4.57f, 2.12f},  {427.5f, 4.66f, 2.06f},
    {459.2f, 5.08f, 0.92f}, {476.8f, 4.81f, 0.63f}, {495.9f, 4.61f, 0.46f},  {516.6f, 4.44f, 0.33f},
    {539.0f, 4.31f, 0.24f}, {563.5f, 4.2f, 0.01f},  {590.4f, 4.01f, 0.006f}, {830.0f, 4.01f, 0.006f}};
/// Beryllium.
constexpr MetalSample kBeryllium[] = {{344.4f, 2.64f, 3.08f}, {364.6f, 2.73f, 3.1f},  {387.4f, 2.84f, 3.12f},
                                      {413.3f, 2.95f, 3.14f}, {442.8f, 3.07f, 3.16f}, {476.8f, 3.19f, 3.16f},
                                      {516.6f, 3.3f, 3.18f},  {563.5f, 3.39f, 3.17f}, {619.9f, 3.46f, 3.18f},
                                      {688.8f, 3.47f, 3.23f}, {774.9f, 3.44f, 3.35f}, {885.6f, 3.35f, 3.55f}};
/// Caesium iodide.
constexpr MetalSample kCaesiumIodide[] = {
    {360.0f, 1.884f, 0.0f}, {380.0f, 1.865f, 0.0f}, {399.9f, 1.851f, 0.0f}, {420.0f, 1.839f, 0.0f},
    {440.0f, 1.829f, 0.0f}, {460.0f, 1.82f, 0.0f},  {480.0f, 1.813f, 0.0f}, {499.9f, 1.807f, 0.0f},
    {520.0f, 1.801f, 0.0f}, {540.0f, 1.797f, 0.0f}, {560.0f, 1.792f, 0.0f}, {579.9f, 1.789f, 0.0f},
    {600.1f, 1.786f, 0.0f}, {619.9f, 1.783f, 0.0f}, {640.1f, 1.78f, 0.0f},  {659.8f, 1.778f, 0.0f},
    {680.1f, 1.776f, 0.0f}, {700.1f, 1.774f, 0.0f}, {720.0f, 1.772f, 0.0f}, {740.2f, 1.77f, 0.0f},
    {760.1f, 1.769f, 0.0f}, {779.7f, 1.767f, 0.0f}, {799.9f, 1.766f, 0.0f}, {820.0f, 1.765f, 0.0f},
    {840.0f, 1.764f, 0.0f}};
/// Copper(I) oxide.
constexpr MetalSample kCopperOneOxide[] = {{350.0f, 2.4f, 1.44f},  {399.9f, 2.8f, 0.99f},   {449.9f, 3.06f, 0.6f},
                                           {499.9f, 3.12f, 0.35f}, {549.8f, 3.1f, 0.19f},   {599.8f, 3.02f, 0.13f},
                                           {649.8f, 2.9f, 0.1f},   {700.1f, 2.83f, 0.083f}, {750.0f, 2.77f, 0.07f},
                                           {799.9f, 2.7f, 0.06f},  {849.8f, 2.66f, 0.053f}};
/// Copper(II) oxide.
constexpr MetalSample kCopperTwoOxide[] = {{350.0f, 2.24f, 1.03f}, {399.9f, 2.34f, 0.87f}, {449.9f, 2.45f, 0.77f},
                                           {499.9f, 2.54f, 0.68f}, {549.8f, 2.58f, 0.59f}, {599.8f, 2.65f, 0.5f},
                                           {649.8f, 2.72f, 0.4f},  {700.1f, 2.88f, 0.31f}, {750.0f, 2.97f, 0.22f},
                                           {799.9f, 2.94f, 0.11f}, {849.8f, 2.81f, 0.04f}};
/// Diamond.
constexpr MetalSample kCubicCarbon[] = {{346.7f, 2.495f, 0.0f}, {404.6f, 2.463f, 0.0f}, {467.8f, 2.441f, 0.0f},
                                        {486.1f, 2.435f, 0.0f}, {508.6f, 2.431f, 0.0f}, {546.0f, 2.424f, 0.0f},
                                        {589.0f, 2.417f, 0.0f}, {643.8f, 2.411f, 0.0f}, {656.3f, 2.41f, 0.0f},
                                        {830.0f, 2.41f, 0.0f}};
/// Mercury telluride.
constexpr MetalSample kMercuryTelluride[] = {
    {359.2f, 2.489f, 1.69f},  {377.0f, 2.525f, 1.73f},  {394.2f, 2.578f, 1.78f},  {410.8f, 2.651f, 1.83f},
    {428.7f, 2.768f, 1.9f},   {445.5f, 2.945f, 1.95f},  {463.5f, 3.138f, 1.86f},  {479.8f, 3.214f, 1.75f},
    {497.1f, 3.252f, 1.68f},  {515.7f, 3.287f, 1.65f},  {531.9f, 3.324f, 1.64f},  {548.8f, 3.382f, 1.65f},
    {566.9f, 3.488f, 1.69f},  {586.5f, 3.719f, 1.67f},  {607.2f, 3.901f, 1.44f},  {623.6f, 3.929f, 1.27f},
    {641.1f, 3.919f, 1.13f},  {659.5f, 3.892f, 1.02f},  {679.3f, 3.86f, 0.936f},  {700.1f, 3.826f, 0.863f},
    {722.1f, 3.795f, 0.802f}, {745.5f, 3.767f, 0.747f}, {762.0f, 3.747f, 0.723f}, {779.7f, 3.729f, 0.696f},
    {797.8f, 3.711f, 0.672f}, {816.7f, 3.691f, 0.655f}, {826.5f, 3.685f, 0.638f}, {830.0f, 3.685f, 0.638f}};
/// Potassium.
constexpr MetalSample kPotassium[] = {{334.2f, 0.089f, 0.288f}, {364.6f, 0.052f, 0.549f}, {405.2f, 0.041f, 0.799f},
                                      {439.6f, 0.043f, 1.02f},  {469.6f, 0.043f, 1.14f},  {506.0f, 0.046f, 1.28f},
                                      {546.2f, 0.049f, 1.43f},  {598.9f, 0.053f, 1.62f},  {663.0f, 0.05f, 1.84f},
                                      {751.4f, 0.044f, 2.19f},  {861.0f, 0.04f, 2.56f}};
/// Lithium.
constexpr MetalSample kLithium[] = {{359.4f, 0.334f, 1.45f}, {393.6f, 0.304f, 1.6f},  {435.0f, 0.247f, 1.82f},
                                    {486.2f, 0.217f, 2.11f}, {551.0f, 0.206f, 2.48f}, {635.8f, 0.221f, 2.94f},
                                    {751.4f, 0.265f, 3.55f}, {830.0f, 0.265f, 3.55f}};
/// Magnesium oxide.
constexpr MetalSample kMagnesiumOxide[] = {{355.5f, 1.776f, 1e-06f}, {382.1f, 1.767f, 0.0f}, {404.6f, 1.761f, 0.0f},
                                           {430.9f, 1.756f, 0.0f},   {457.8f, 1.751f, 0.0f}, {477.9f, 1.748f, 0.0f},
                                           {499.9f, 1.745f, 0.0f},   {546.2f, 1.741f, 0.0f}, {589.3f, 1.737f, 0.0f},
                                           {632.9f, 1.735f, 0.0f},   {656.3f, 1.733f, 0.0f}, {690.7f, 1.732f, 0.0f},
                                           {767.7f, 1.729f, 0.0f},   {830.0f, 1.729f, 0.0f}};
/// Molybdenum.
constexpr MetalSample kMolybdenum[] = {{354.2f, 3.06f, 3.21f}, {375.7f, 3.06f, 3.18f}, {399.9f, 3.03f, 3.22f},
                                       {427.5f, 3.05f, 3.33f}, {459.2f, 3.13f, 3.51f}, {476.8f, 3.22f, 3.61f},
                                       {495.9f, 3.36f, 3.73f}, {516.6f, 3.59f, 3.78f}, {539.0f, 3.79f, 3.61f},
                                       {563.5f, 3.76f, 3.41f}, {590.4f, 3.68f, 3.45f}, {619.9f, 3.68f, 3.52f},
                                       {652.5f, 3.74f, 3.58f}, {688.8f, 3.81f, 3.58f}, {729.3f, 3.84f, 3.51f},
                                       {774.9f, 3.77f, 3.41f}, {826.5f, 3.53f, 3.3f},  {885.6f, 3.15f, 3.4f}};
/// Sodium.
constexpr MetalSample kSodium[] = {{334.2f, 0.055f, 1.13f}, {364.6f, 0.061f, 1.33f}, {387.4f, 0.065f, 1.47f},
                                   {405.2f, 0.069f, 1.54f}, {439.6f, 0.068f, 1.76f}, {469.6f, 0.066f, 1.88f},
                                   {506.0f, 0.063f, 2.07f}, {546.2f, 0.059f, 2.23f}, {598.9f, 0.053f, 2.48f},
                                   {663.0f, 0.049f, 2.76f}, {751.4f, 0.05f, 3.22f},  {861.0f, 0.053f, 3.72f}};
/// Niobium.
constexpr MetalSample kNiobium[] = {{354.2f, 2.48f, 2.33f}, {375.7f, 2.44f, 2.45f}, {399.9f, 2.48f, 2.6f},
                                    {435.0f, 2.58f, 2.8f},  {467.8f, 2.74f, 2.9f},  {486.2f, 2.83f, 2.92f},
                                    {506.0f, 2.89f, 2.9f},  {527.6f, 2.92f, 2.88f}, {551.0f, 2.93f, 2.87f},
                                    {576.7f, 2.92f, 2.87f}, {604.8f, 2.89f, 2.87f}, {635.8f, 2.82f, 2.86f},
                                    {670.2f, 2.69f, 2.89f}, {708.5f, 2.54f, 2.99f}, {751.4f, 2.36f, 3.13f},
                                    {799.9f, 2.15f, 3.37f}, {855.0f, 1.95f, 3.68f}};
/// Rhodium.
constexpr MetalSample kRhodium[] = {{354.2f, 1.04f, 3.71f}, {375.7f, 1.2f, 3.97f},  {399.9f, 1.41f, 4.2f},
                                    {427.5f, 1.63f, 4.36f}, {459.2f, 1.8f, 4.49f},  {476.8f, 1.85f, 4.55f},
                                    {495.9f, 1.88f, 4.65f}, {516.6f, 1.9f, 4.78f},  {539.0f, 1.94f, 4.94f},
                                    {563.5f, 2.0f, 5.11f},  {590.4f, 2.05f, 5.3f},  {619.9f, 2.12f, 5.51f},
                                    {652.5f, 2.2f, 5.76f},  {688.8f, 2.3f, 6.02f},  {729.3f, 2.42f, 6.33f},
                                    {774.9f, 2.6f, 6.64f},  {826.5f, 2.78f, 6.97f}, {885.6f, 3.01f, 7.31f}};
/// Selenium, ordinary ray.
constexpr MetalSample kSelenium[] = {{344.4f, 3.06f, 1.47f}, {364.6f, 3.22f, 1.24f}, {387.4f, 3.35f, 1.01f},
                                     {413.3f, 3.3f, 0.7f},   {442.8f, 3.12f, 0.58f}, {476.8f, 3.0f, 0.53f},
                                     {516.6f, 2.93f, 0.61f}, {563.5f, 3.07f, 0.73f}, {619.9f, 3.38f, 0.65f},
                                     {688.8f, 3.32f, 0.11f}, {830.0f, 3.32f, 0.11f}};
/// Silicon carbide.
constexpr MetalSample kSiliconCarbide[] = {
    {354.2f, 2.836f, 0.00289f}, {375.7f, 2.799f, 0.00138f}, {399.9f, 2.765f, 0.000191f}, {435.8f, 2.731f, 6.78e-21f},
    {467.0f, 2.707f, 0.0f},     {495.9f, 2.684f, 1.2e-05f}, {515.1f, 2.679f, 0.0f},      {546.2f, 2.663f, 0.0f},
    {567.9f, 2.656f, 0.0f},     {589.0f, 2.649f, 0.0f},     {615.9f, 2.641f, 0.0f},      {656.3f, 2.63f, 0.0f},
    {691.1f, 2.624f, 0.0f},     {826.5f, 2.598f, 0.0f},     {830.0f, 2.598f, 0.0f}};
/// Tin telluride.
constexpr MetalSample kTinTelluride[] = {{332.1f, 1.007f, 0.0f}, {361.0f, 1.103f, 0.0f}, {390.2f, 1.228f, 0.0f},
                                         {414.4f, 1.364f, 0.0f}, {453.3f, 1.551f, 0.0f}, {498.3f, 1.702f, 0.0f},
                                         {533.5f, 1.813f, 0.0f}, {550.5f, 1.989f, 0.0f}, {582.3f, 2.991f, 0.0f},
                                         {606.0f, 3.273f, 0.0f}, {648.1f, 3.701f, 0.0f}, {681.2f, 3.912f, 0.0f},
                                         {748.7f, 4.285f, 0.0f}, {804.0f, 4.541f, 0.0f}, {867.5f, 4.803f, 0.0f}};
/// Tantalum.
constexpr MetalSample kTantalum[] = {
    {344.4f, 2.49f, 2.3f},  {364.6f, 2.61f, 2.33f}, {387.4f, 2.73f, 2.31f}, {413.3f, 2.81f, 2.24f},
    {442.8f, 2.85f, 2.14f}, {459.2f, 2.84f, 2.08f}, {476.8f, 2.8f, 2.02f},  {495.9f, 2.75f, 1.98f},
    {516.6f, 2.68f, 1.92f}, {539.0f, 2.56f, 1.86f}, {563.5f, 2.36f, 1.81f}, {590.4f, 2.1f, 1.84f},
    {619.9f, 1.83f, 1.99f}, {652.5f, 1.57f, 2.24f}, {688.8f, 1.35f, 2.6f},  {729.3f, 1.24f, 2.95f},
    {774.9f, 1.15f, 3.33f}, {826.5f, 1.09f, 3.73f}, {885.6f, 1.04f, 4.15f}};
/// Tellurium, ordinary ray.
constexpr MetalSample kTellurium[] = {
    {354.2f, 1.72f, 2.7f},  {381.5f, 2.02f, 3.03f},  {404.0f, 2.37f, 3.29f}, {430.0f, 2.77f, 3.47f},
    {459.7f, 3.27f, 3.66f}, {476.1f, 3.55f, 3.72f},  {498.5f, 3.91f, 3.77f}, {516.6f, 4.24f, 3.77f},
    {538.8f, 4.62f, 3.69f}, {561.2f, 5.01f, 3.57f},  {599.2f, 5.67f, 3.16f}, {619.9f, 5.94f, 2.69f},
    {642.4f, 6.07f, 2.45f}, {658.4f, 6.11f, 2.25f},  {674.9f, 6.12f, 2.02f}, {692.6f, 6.09f, 1.72f},
    {710.9f, 6.04f, 1.52f}, {730.6f, 5.95f, 1.36f},  {750.9f, 5.87f, 1.26f}, {772.9f, 5.86f, 1.17f},
    {796.3f, 5.84f, 1.06f}, {820.5f, 5.78f, 0.895f}, {846.9f, 5.68f, 0.76f}};
/// Thorium fluoride.
constexpr MetalSample kThoriumFluoride[] = {{360.0f, 1.534f, 0.0f}, {380.0f, 1.531f, 0.0f}, {399.9f, 1.529f, 0.0f},
                                            {420.0f, 1.527f, 0.0f}, {440.0f, 1.526f, 0.0f}, {460.0f, 1.524f, 0.0f},
                                            {480.0f, 1.523f, 0.0f}, {499.9f, 1.523f, 0.0f}, {520.0f, 1.522f, 0.0f},
                                            {540.0f, 1.521f, 0.0f}, {560.0f, 1.521f, 0.0f}, {579.9f, 1.52f, 0.0f},
                                            {600.1f, 1.52f, 0.0f},  {619.9f, 1.52f, 0.0f},  {640.1f, 1.519f, 0.0f},
                                            {659.8f, 1.519f, 0.0f}, {700.1f, 1.519f, 0.0f}, {739.7f, 1.518f, 0.0f},
                                            {779.7f, 1.518f, 0.0f}, {799.9f, 1.518f, 0.0f}, {830.0f, 1.518f, 0.0f}};
/// Titanium carbide.
constexpr MetalSample kTitaniumCarbide[] = {{354.2f, 2.57f, 2.34f}, {413.3f, 2.78f, 2.43f}, {495.9f, 2.95f, 2.38f},
                                            {619.9f, 3.05f, 2.67f}, {826.5f, 3.51f, 3.07f}, {830.0f, 3.51f, 3.07f}};
/// Titanium dioxide, ordinary ray.
constexpr MetalSample kTitaniumDioxide[] = {
    {360.0f, 3.87f, 0.251f}, {388.0f, 3.49f, 0.0f}, {412.0f, 3.24f, 0.022f}, {440.0f, 3.2f, 0.0f},
    {460.0f, 3.13f, 0.0f},   {480.0f, 3.08f, 0.0f}, {499.9f, 3.03f, 0.0f},   {520.0f, 3.0f, 0.0f},
    {539.0f, 2.95f, 0.0f},   {560.0f, 2.94f, 0.0f}, {579.9f, 2.92f, 0.0f},   {600.1f, 2.9f, 0.0f},
    {619.9f, 2.88f, 0.0f},   {640.1f, 2.87f, 0.0f}, {659.8f, 2.85f, 0.0f},   {680.1f, 2.84f, 0.0f},
    {700.1f, 2.83f, 0.0f},   {720.0f, 2.82f, 0.0f}, {740.2f, 2.81f, 0.0f},   {760.1f, 2.81f, 0.0f},
    {779.7f, 2.8f, 0.0f},    {799.9f, 2.79f, 0.0f}, {820.0f, 2.79f, 0.0f},   {840.0f, 2.78f, 0.0f}};
/// Vanadium carbide.
constexpr MetalSample kVanadiumCarbide[] = {{354.2f, 2.59f, 2.12f}, {413.3f, 2.77f, 2.16f}, {495.9f, 2.84f, 2.21f},
                                            {619.9f, 3.01f, 2.51f}, {826.5f, 3.37f, 2.88f}, {830.0f, 3.37f, 2.88f}};
/// Vanadium nitride.
constexpr MetalSample kVanadiumNitride[] = {{354.2f, 2.18f, 1.58f}, {413.3f, 2.13f, 1.7f},  {495.9f, 2.17f, 1.98f},
                                            {619.9f, 2.35f, 2.47f}, {826.5f, 2.73f, 2.92f}, {830.0f, 2.73f, 2.92f}};

constexpr NamedMetal kPalikMetals[] = {{"a-C", kAmorphousCarbon},
                                       {"AlAs", kAluminiumArsenide},
                                       {"AlSb", kAluminiumAntimonide},
                                       {"Be", kBeryllium},
                                       {"CsI", kCaesiumIodide},
                                       {"Cu2O", kCopperOneOxide},
                                       {"CuO", kCopperTwoOxide},
                                       {"d-C", kCubicCarbon},
                                       {"HgTe", kMercuryTelluride},
                                       {"K", kPotassium},
                                       {"Li", kLithium},
                                       {"MgO", kMagnesiumOxide},
                                       {"Mo", kMolybdenum},
                                       {"Na", kSodium},
                                       {"Nb", kNiobium},
                                       {"Rh", kRhodium},
                                       {"Se", kSelenium},
                                       {"SiC", kSiliconCarbide},
                                       {"SnTe", kTinTelluride},
                                       {"Ta", kTantalum},
                                       {"Te", kTellurium},
                                       {"ThF4", kThoriumFluoride},
                                       {"TiC", kTitaniumCarbide},
                                       {"TiO2", kTitaniumDioxide},
                                       {"VC", kVanadiumCarbide},
                                       {"VN", kVanadiumNitride}};

}  // namespace

std::span<const NamedMetal> palik_metals() { return kPalikMetals; }

}  // namespace sheaf
