"""Words that are no names in some version of GLSL: reserved (3.6 of the specifications of GLSL 1.10 to 4.60, of ES 1.00
to 3.20, and GL_KHR_vulkan_glsl), or functions that are built in (chapter 8 of the same)."""

from __future__ import annotations

__all__ = ["forbidden"]

_RESERVED_WORDS = """
    active asm atomic_uint attribute bool break buffer bvec2 bvec3 bvec4 case cast centroid class coherent common
    const continue default demote discard dmat2 dmat3 dmat4 do double dvec2 dvec3 dvec4 else enum extern external
    false filter fixed flat float for fvec2 fvec3 fvec4 goto half highp hvec2 hvec3 hvec4 if iimage1D iimage2D
    iimage3D iimageBuffer iimageCube image1D image2D image3D imageBuffer imageCube in inline inout input int interface
    invariant isampler1D isampler2D isampler3D isamplerBuffer isamplerCube itexture2D ivec2 ivec3 ivec4 layout long
    lowp mat2 mat3 mat4 mediump namespace noinline noperspective out output packed partition patch precise precision
    public readonly resource restrict return sample sampler sampler1D sampler2D sampler3D samplerBuffer samplerCube
    samplerShadow shared short sizeof smooth static struct subpassInput subroutine superp switch template texture1D
    texture2D texture3D this true typedef uimage2D uimage3D uint union unsigned usampler1D usampler2D usampler3D
    uniform using usubpassInput uvec2 uvec3 uvec4 varying vec2 vec3 vec4 void volatile while workgroupcoherent
    writeonly
"""
_BUILT_IN_WORDS = """
    abs acos acosh all allInvocations any anyInvocation asin asinh atan atanh atomicAdd atomicAnd atomicCompSwap
    atomicCounter atomicExchange atomicMax atomicMin atomicOr atomicXor barrier bitCount bitfieldExtract
    bitfieldInsert bitfieldReverse ceil clamp cos cosh cross dFdx dFdxCoarse dFdxFine dFdy dFdyCoarse dFdyFine degrees
    determinant distance dot equal exp exp2 faceforward findLSB findMSB floatBitsToInt floatBitsToUint floor fma fract
    frexp ftransform fwidth fwidthCoarse fwidthFine greaterThan greaterThanEqual groupMemoryBarrier imageAtomicAdd
    imageLoad imageSize imageStore imulExtended intBitsToFloat interpolateAtCentroid interpolateAtOffset
    interpolateAtSample inverse inversesqrt isinf isnan ldexp length lessThan lessThanEqual log log2 matrixCompMult
    max memoryBarrier min mix mod modf noise1 noise2 noise3 noise4 normalize not notEqual outerProduct packDouble2x32
    packHalf2x16 packSnorm2x16 packSnorm4x8 packUnorm2x16 packUnorm4x8 pow radians reflect refract round roundEven
    shadow1D shadow2D sign sin sinh smoothstep sqrt step subpassLoad tan tanh texelFetch texelFetchOffset texture
    texture1D texture2D texture3D textureCube textureGather textureGrad textureLod textureOffset textureProj
    textureQueryLevels textureQueryLod textureSize transpose trunc uaddCarry uintBitsToFloat umulExtended
    unpackDouble2x32 unpackHalf2x16 unpackSnorm2x16 unpackSnorm4x8 unpackUnorm2x16 unpackUnorm4x8 usubBorrow
"""
_RESERVED, _BUILT_IN = frozenset(_RESERVED_WORDS.split()), frozenset(_BUILT_IN_WORDS.split())


def forbidden(name: str) -> str:
    """Why a name is none: a phrase; "" where it is one."""
    if name in _RESERVED:
        return "reserved in some version of GLSL"
    if name in _BUILT_IN:
        return "a function of GLSL's own in some version"
    return "reserved: two underscores" if "__" in name else ""
